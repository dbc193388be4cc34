//! YUV4MPEG2: raw video, its frames' size and sampling told once in a header. A frame becomes a
//! PNM.

use super::end::End;
use super::error::{StreamError, Y4mFault};
use crate::size::check_size;
use crate::yuv::Range;

const MAGIC: &[u8] = b"YUV4MPEG2 ";
const FRAME: &[u8] = b"FRAME";
/// The longest header of a stream or a frame.
const MAX_HEADER: usize = 1024;

/// How many pixels share a sample of colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sampling {
    Mono,
    /// Columns and rows.
    Colour(usize, usize),
}

/// What a stream's header says of its frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Y4m {
    width: usize,
    height: usize,
    sampling: Sampling,
    range: Range,
}

/// Whether a header begins.
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// The header that `bytes` begins with, and its length; `None` where there is none, or not yet.
pub(super) fn header(bytes: &[u8]) -> Option<Result<(Y4m, usize), StreamError>> {
    let parameters = bytes.strip_prefix(MAGIC)?;
    let line = &bytes[..bytes.len().min(MAX_HEADER)];
    let Some(end) = line.iter().position(|&byte| byte == b'\n') else {
        let endless = bytes.len() >= MAX_HEADER;
        return endless.then_some(Err(StreamError::Y4m(Y4mFault::LongHeader)));
    };
    let parameters = String::from_utf8_lossy(&parameters[..end - MAGIC.len()]).into_owned();
    Some(parse(&parameters).map(|y4m| (y4m, end + 1)))
}

fn parse(parameters: &str) -> Result<Y4m, StreamError> {
    let mut size = [0u32; 2];
    let mut sampling = Sampling::Colour(2, 2);
    let mut range = Range::Limited;
    for parameter in parameters.split_ascii_whitespace() {
        let unknown = || StreamError::Y4m(Y4mFault::Parameter(parameter.to_owned()));
        let (name, value) = parameter.split_at_checked(1).ok_or_else(unknown)?;
        match name {
            "W" => size[0] = value.parse().map_err(|_| unknown())?,
            "H" => size[1] = value.parse().map_err(|_| unknown())?,
            // How 4:2:0 is sited moves colour by less than a pixel.
            "C" => {
                sampling = match value {
                    "420" | "420jpeg" | "420paldv" | "420mpeg2" => Sampling::Colour(2, 2),
                    "422" => Sampling::Colour(2, 1),
                    "444" => Sampling::Colour(1, 1),
                    "mono" => Sampling::Mono,
                    _ => return Err(unknown()),
                }
            }
            "X" if value == "COLORRANGE=FULL" => range = Range::Full,
            // The frame rate, the pixels' aspect and the interlacing change no picture's content.
            _ => {}
        }
    }
    let [width, height] = size;
    check_size(width, height).map_err(|_| match width == 0 || height == 0 {
        true => StreamError::Y4m(Y4mFault::NoSize),
        false => StreamError::TooLarge,
    })?;
    Ok(Y4m { width: width as usize, height: height as usize, sampling, range })
}

impl Y4m {
    /// Where the frame that `bytes` begins with ends; unknown where something else begins but
    /// another header.
    pub(super) fn end_of_frame(&self, bytes: &[u8]) -> End {
        if !bytes.is_empty() && (MAGIC.starts_with(bytes) || begins(bytes)) {
            return End::NeedsMore;
        }
        let length = bytes.len().min(FRAME.len());
        if bytes[..length] != FRAME[..length] {
            return End::Unknown;
        }
        let line = &bytes[..bytes.len().min(MAX_HEADER)];
        match line.iter().position(|&byte| byte == b'\n') {
            Some(end) => End::At(end + 1 + self.frame_bytes()),
            None if bytes.len() >= MAX_HEADER => End::Unknown,
            None => End::NeedsMore,
        }
    }

    /// The bytes of a frame's samples.
    fn frame_bytes(&self) -> usize {
        let pixels = self.width * self.height;
        match self.sampling {
            Sampling::Mono => pixels,
            Sampling::Colour(columns, rows) => {
                pixels + 2 * self.width.div_ceil(columns) * self.height.div_ceil(rows)
            }
        }
    }

    /// A whole frame, as [`Self::end_of_frame`] bounds it, as a binary PNM.
    pub(super) fn to_pnm(&self, frame: &[u8]) -> Vec<u8> {
        let samples = &frame[frame.len().saturating_sub(self.frame_bytes())..];
        let (luma, colour) = samples.split_at(samples.len().min(self.width * self.height));
        let (format, channels) = if self.sampling == Sampling::Mono { ("P5", 1) } else { ("P6", 3) };
        let mut pnm = format!("{format}\n{} {}\n255\n", self.width, self.height).into_bytes();
        pnm.reserve_exact(luma.len() * channels);
        let Sampling::Colour(columns, rows) = self.sampling else {
            // A conversion to an integer type saturates.
            pnm.extend(luma.iter().map(|&y| self.range.brightness(y).round() as u8));
            return pnm;
        };
        let (blue, red) = colour.split_at(colour.len() / 2);
        let stride = self.width.div_ceil(columns);
        for (row, luma) in luma.chunks_exact(self.width).enumerate() {
            let of_row = row / rows * stride..(row / rows + 1) * stride;
            let (blue, red) = (&blue[of_row.clone()], &red[of_row]);
            for (column, &y) in luma.iter().enumerate() {
                let (cb, cr) = (blue[column / columns], red[column / columns]);
                pnm.extend(self.range.rgb(y, [cb, cr]));
            }
        }
        pnm
    }
}
