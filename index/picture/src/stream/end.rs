//! Where an encoded picture ends, by its format alone.

use super::error::MAX_FRAME_BYTES;
use crate::jpeg::EndScan;
use crate::limits::MAX_PIXELS;
use crate::png;

/// The longest PNM header that is searched for its numbers.
const MAX_HEADER: usize = 4096;

/// Where a frame ends.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum End {
    At(usize),
    NeedsMore,
    /// No end can be told from the bytes: the rest of the stream is one picture.
    Unknown,
    TooLarge,
}

/// How far the frame that is coming was looked at, so that each byte is looked at once, however
/// many reads it comes in.
#[derive(Debug, Default)]
pub(super) struct Scan {
    jpeg: EndScan,
    /// Where the next chunk of a PNG begins.
    chunk: usize,
}

/// A format whose pictures say where they end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Pnm,
    Pam,
    Jpeg,
    Png,
    Bmp,
    WebP,
}

impl Kind {
    /// The format of what `bytes` begins with. Of a byte or two it may be too early to tell.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [b'P', b'4'..=b'6', byte, ..] if byte.is_ascii_whitespace() || *byte == b'#' => Some(Self::Pnm),
            [b'P', b'7', b'\n', ..] => Some(Self::Pam),
            [0xFF, 0xD8, 0xFF, ..] => Some(Self::Jpeg),
            [b'B', b'M', _, _, _, _, 0, 0, 0, 0, ..] => Some(Self::Bmp),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            _ if bytes.starts_with(png::SIGNATURE) => Some(Self::Png),
            _ => None,
        }
    }

    /// Where the picture that `bytes` begins with ends.
    pub(super) fn end(self, bytes: &[u8], scan: &mut Scan) -> End {
        match self {
            Self::Pnm => end_of_pnm(bytes),
            Self::Pam => end_of_pam(bytes),
            Self::Jpeg => scan.jpeg.end(bytes).map_or(End::NeedsMore, End::At),
            Self::Png => end_of_png(bytes, &mut scan.chunk),
            // The file's length stands behind its first bytes.
            Self::Bmp => end_by_length(bytes, 2, 0),
            Self::WebP => end_by_length(bytes, 4, 8),
        }
    }

    /// How many bytes go before what may be the next picture of this format, or the header of a
    /// part that holds one.
    pub(super) fn find(self, bytes: &[u8]) -> usize {
        let first = match self {
            Self::Pnm | Self::Pam => b'P',
            Self::Jpeg => 0xFF,
            Self::Png => png::SIGNATURE[0],
            Self::Bmp => b'B',
            Self::WebP => b'R',
        };
        let is_next = |at: &usize| {
            let rest = &bytes[*at..];
            // The end of what has come may be its beginning.
            let may_be = rest.len() < LONGEST_SIGNATURE || Self::of(rest) == Some(self);
            rest[0] == first && may_be || *at > 0 && rest.starts_with(b"\n--")
        };
        (0..bytes.len()).find(is_next).unwrap_or(bytes.len())
    }
}

/// How many bytes [`Kind::of`] looks at.
pub(super) const LONGEST_SIGNATURE: usize = 12;

/// A length of 32 bits at a place in the header, which counts all but `besides` bytes.
fn end_by_length(bytes: &[u8], at: usize, besides: usize) -> End {
    let Some(&[a, b, c, d]) = bytes.get(at..at + 4) else { return End::NeedsMore };
    match usize::try_from(u32::from_le_bytes([a, b, c, d])).unwrap_or(usize::MAX).saturating_add(besides) {
        length if length > MAX_FRAME_BYTES => End::TooLarge,
        // Some writers of BMP leave it out.
        length if length < LONGEST_SIGNATURE => End::Unknown,
        length => End::At(length),
    }
}

/// The end of a PNG: its chunks say how long they are, and the last is named IEND. `next` is where
/// the next chunk to look at begins.
fn end_of_png(bytes: &[u8], next: &mut usize) -> End {
    *next = png::SIGNATURE.len().max(*next);
    loop {
        let Some(&[a, b, c, d, ref kind @ ..]) = bytes.get(*next..*next + 8) else {
            return End::NeedsMore;
        };
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        if length > MAX_FRAME_BYTES - *next {
            return End::TooLarge;
        }
        let end = *next + length + png::CHUNK_OVERHEAD;
        if kind == b"IEND" {
            return End::At(end);
        }
        if end > MAX_FRAME_BYTES {
            return End::TooLarge;
        }
        *next = end;
    }
}

/// The end of a binary PNM: its header's numbers say how many bytes follow.
fn end_of_pnm(bytes: &[u8]) -> End {
    let bitmap = bytes.get(1) == Some(&b'4');
    let channels = if bytes.get(1) == Some(&b'6') { 3 } else { 1 };
    let mut at = 2;
    let mut numbers = [0u64; 3];
    for number in numbers.iter_mut().take(if bitmap { 2 } else { 3 }) {
        // White space and comments, then digits.
        loop {
            match bytes.get(at) {
                _ if at > MAX_HEADER => return End::Unknown,
                None => return End::NeedsMore,
                Some(b'#') => match bytes[at..].iter().position(|&byte| byte == b'\n') {
                    Some(length) => at += length,
                    None if bytes.len() > MAX_HEADER => return End::Unknown,
                    None => return End::NeedsMore,
                },
                Some(byte) if byte.is_ascii_whitespace() => at += 1,
                Some(byte) if byte.is_ascii_digit() => break,
                Some(_) => return End::Unknown,
            }
        }
        loop {
            match bytes.get(at) {
                _ if at > MAX_HEADER => return End::Unknown,
                None => return End::NeedsMore,
                Some(byte) if byte.is_ascii_digit() => {
                    *number = *number * 10 + u64::from(byte - b'0');
                    if *number > u64::from(u32::MAX) {
                        return End::TooLarge;
                    }
                    at += 1;
                }
                Some(_) => break,
            }
        }
    }
    let [width, height, most] = numbers;
    if width.saturating_mul(height) > MAX_PIXELS {
        return End::TooLarge;
    }
    let row = if bitmap { width.div_ceil(8) } else { width * channels * if most > 255 { 2 } else { 1 } };
    match usize::try_from(row.saturating_mul(height)) {
        // One white space ends the header.
        Ok(body) if body <= MAX_FRAME_BYTES => End::At(at + 1 + body),
        _ => End::TooLarge,
    }
}

/// The end of a PAM (P7): its header is lines of a name and a value, up to `ENDHDR`.
fn end_of_pam(bytes: &[u8]) -> End {
    let header = bytes.get(..MAX_HEADER).unwrap_or(bytes);
    let Some(end) = header.windows(7).position(|window| window == b"ENDHDR\n").map(|at| at + 7) else {
        return if bytes.len() > MAX_HEADER { End::Unknown } else { End::NeedsMore };
    };
    let text = String::from_utf8_lossy(&header[..end]);
    let number = |name: &str| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim().parse().ok()
    };
    let numbers = number("WIDTH ").zip(number("HEIGHT ")).zip(number("DEPTH ")).zip(number("MAXVAL "));
    let Some((((width, height), depth), most)) = numbers else { return End::Unknown };
    let pixels = width.saturating_mul(height);
    let bytes_a_pixel = depth.saturating_mul(if most > 255 { 2 } else { 1 });
    match usize::try_from(pixels.saturating_mul(bytes_a_pixel)) {
        Ok(body) if pixels <= MAX_PIXELS && body <= MAX_FRAME_BYTES => End::At(end + body),
        _ => End::TooLarge,
    }
}
