//! A stream of pictures on one pipe: PNM, JPEG or PNG frames, one behind the other.
//!
//! `ffmpeg -i video.mp4 -f image2pipe -c:v ppm -` (or `-c:v mjpeg`, or `-c:v png`) writes such a stream. Where a frame ends is
//! found from the format alone, without decoding, and at most one frame is held in memory.

use std::io::{self, Read};

use super::MAX_PIXELS;

/// The most bytes that one frame may have: the largest allowed picture as 16-bit RGB, and its header.
const MAX_FRAME_BYTES: usize = MAX_PIXELS as usize * 6 + 4096;
/// How much is asked of the pipe at once.
const CHUNK: usize = 64 * 1024;
/// The longest PNM header that is searched for its numbers.
const MAX_HEADER: usize = 4096;

/// Why a stream cannot be split any further.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The pipe cannot be read.
    #[error("cannot read standard input: {0}")]
    Read(#[from] io::Error),
    /// A frame does not end within what a picture may have.
    #[error("a frame of the stream is larger than {} megapixels: shrink the frames first", MAX_PIXELS >> 20)]
    TooLarge,
}

/// Splits a byte stream into the encoded pictures in it, as an iterator of their bytes.
///
/// PNM (binary: P4, P5, P6, P7), JPEG and PNG frames are told apart by their first bytes. Anything else is one picture
/// up to the end of the stream, and so is a last frame that is cut short: decoding then says what is wrong.
#[derive(Debug)]
pub struct Frames<R> {
    input: R,
    buffer: Vec<u8>,
    jpeg: JpegScan,
    ended: bool,
    failed: bool,
}

/// Where a frame ends.
#[derive(Debug, PartialEq, Eq)]
enum End {
    At(usize),
    NeedsMore,
    /// No end can be told from the bytes: the rest of the stream is one picture.
    Unknown,
    TooLarge,
}

impl<R: Read> Frames<R> {
    /// Splits what `input` gives.
    pub fn new(input: R) -> Self {
        Self { input, buffer: Vec::new(), jpeg: JpegScan::default(), ended: false, failed: false }
    }

    /// Whether anything follows the frames given so far. It waits for the pipe.
    pub fn has_more(&mut self) -> bool {
        // What is wrong with the pipe is the next frame's news.
        self.failed
            || !self.buffer.is_empty()
            || (!self.ended && self.read_more().is_ok() && !self.buffer.is_empty())
    }

    /// Takes what the pipe has ready: waiting for a full chunk would hold a live camera's frame back.
    fn read_more(&mut self) -> Result<(), StreamError> {
        let held = self.buffer.len();
        self.buffer.resize(held + CHUNK, 0);
        let read = loop {
            match self.input.read(&mut self.buffer[held..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                outcome => break outcome,
            }
        };
        self.buffer.truncate(held + *read.as_ref().unwrap_or(&0));
        self.ended = read? == 0;
        Ok(())
    }

    fn next_frame(&mut self) -> Result<Option<Vec<u8>>, StreamError> {
        loop {
            match end_of_frame(&self.buffer, &mut self.jpeg) {
                End::At(end) if end <= self.buffer.len() => return Ok(Some(self.take(end))),
                End::TooLarge => return Err(StreamError::TooLarge),
                End::At(_) | End::NeedsMore | End::Unknown if self.ended => {
                    let rest = self.buffer.len();
                    return Ok((rest > 0).then(|| self.take(rest)));
                }
                _ if self.buffer.len() > MAX_FRAME_BYTES => return Err(StreamError::TooLarge),
                _ => self.read_more()?,
            }
        }
    }

    fn take(&mut self, end: usize) -> Vec<u8> {
        self.jpeg = JpegScan::default();
        let rest = self.buffer.split_off(end);
        std::mem::replace(&mut self.buffer, rest)
    }
}

impl<R: Read> Iterator for Frames<R> {
    type Item = Result<Vec<u8>, StreamError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let frame = self.next_frame().transpose();
        self.failed = matches!(frame, Some(Err(_)));
        frame
    }
}

fn end_of_frame(bytes: &[u8], jpeg: &mut JpegScan) -> End {
    match bytes {
        [] | [_] => End::NeedsMore,
        [b'P', b'4'..=b'6', ..] => end_of_pnm(bytes),
        [b'P', b'7', ..] => end_of_pam(bytes),
        [0xFF, 0xD8, ..] => jpeg.end(bytes),
        [0x89, b'P', ..] => end_of_png(bytes),
        _ => End::Unknown,
    }
}

/// The bytes before the first chunk of a PNG.
const PNG_SIGNATURE: usize = 8;
/// What a PNG chunk has besides its data: length, type and checksum, four bytes each.
const PNG_CHUNK: usize = 12;

/// The end of a PNG: its chunks say how long they are, and the last is named IEND.
fn end_of_png(bytes: &[u8]) -> End {
    let mut at = PNG_SIGNATURE;
    loop {
        let Some(&[a, b, c, d, ref kind @ ..]) = bytes.get(at..at + 8) else {
            return End::NeedsMore;
        };
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        if length > MAX_FRAME_BYTES - at {
            return End::TooLarge;
        }
        at += length + PNG_CHUNK;
        if kind == b"IEND" {
            return End::At(at);
        }
        if at > MAX_FRAME_BYTES {
            return End::TooLarge;
        }
    }
}

/// The end of a binary PNM: its header's numbers say how many bytes follow.
fn end_of_pnm(bytes: &[u8]) -> End {
    let bitmap = bytes[1] == b'4';
    let channels = if bytes[1] == b'6' { 3 } else { 1 };
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

/// Whether a JPEG lacks its end marker. Decoders fill the missing part with grey and say nothing.
pub(super) fn is_cut_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF, 0xD8]) && JpegScan::default().end(bytes) == End::NeedsMore
}

/// Walks the segments of a JPEG. It remembers where it stopped, so that each byte is looked at once.
#[derive(Debug, Default)]
struct JpegScan {
    at: usize,
    in_entropy_coded: bool,
}

impl JpegScan {
    fn end(&mut self, bytes: &[u8]) -> End {
        self.at = self.at.max(2);
        loop {
            if self.in_entropy_coded {
                // FF 00 is a stuffed byte and FF D0..D7 a restart; any other marker ends the scan.
                match bytes.get(self.at..).and_then(|rest| rest.iter().position(|&byte| byte == 0xFF)) {
                    None => {
                        self.at = bytes.len();
                        return End::NeedsMore;
                    }
                    Some(skip) => self.at += skip,
                }
                match bytes.get(self.at + 1) {
                    None => return End::NeedsMore,
                    Some(0x00 | 0xD0..=0xD7) => self.at += 2,
                    Some(0xFF) => self.at += 1,
                    // The next frame: this one was cut short, and decoding will say so.
                    Some(0xD8) => return End::At(self.at),
                    Some(_) => self.in_entropy_coded = false,
                }
                continue;
            }
            match (bytes.get(self.at), bytes.get(self.at + 1)) {
                (None, _) | (_, None) => return End::NeedsMore,
                (Some(0xFF), Some(0xD9)) => return End::At(self.at + 2),
                (Some(0xFF), Some(0xFF)) => self.at += 1,
                (Some(0xFF), Some(0x01 | 0xD0..=0xD8)) => self.at += 2,
                (Some(0xFF), Some(&marker)) => {
                    let (Some(&high), Some(&low)) = (bytes.get(self.at + 2), bytes.get(self.at + 3)) else {
                        return End::NeedsMore;
                    };
                    let length = usize::from(u16::from_be_bytes([high, low]));
                    if length < 2 {
                        return End::Unknown;
                    }
                    self.at += 2 + length;
                    self.in_entropy_coded = marker == 0xDA;
                }
                _ => return End::Unknown,
            }
        }
    }
}
