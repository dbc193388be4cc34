//! Why a stream cannot be split.

use std::io;

use crate::limits::MAX_PIXELS;

/// The most bytes that one frame may have: the largest allowed picture as 16-bit RGB, and its
/// header.
pub(super) const MAX_FRAME_BYTES: usize = MAX_PIXELS as usize * 6 + 4096;

/// Why a stream cannot be split any further.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The pipe cannot be read.
    #[error("cannot read standard input: {0}")]
    Read(#[from] io::Error),
    /// A frame does not end within what a picture may have.
    #[error("a frame of the stream is larger than {} megapixels: shrink the frames first", MAX_PIXELS >> 20)]
    TooLarge,
    /// A YUV4MPEG2 stream of a variety that is not read.
    #[error(
        "YUV4MPEG2: {0} is not read; ask for 4:2:0, 4:2:2, 4:4:4 or mono in 8 bits, as `ffmpeg -pix_fmt yuv420p` does"
    )]
    Y4m(String),
}
