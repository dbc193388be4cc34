//! Why a stream cannot be split.

use std::io;

use crate::limits::MAX_PIXELS;

/// The most bytes that one frame may have: the largest allowed picture as 16-bit RGB, and its
/// header.
pub(super) const MAX_FRAME_BYTES: usize = MAX_PIXELS as usize * 6 + 4096;

/// Why a stream cannot be split any further.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StreamError {
    /// The pipe or file cannot be read.
    #[error("cannot read the stream: {0}")]
    Read(#[from] io::Error),
    /// A frame does not end within what a picture may have.
    #[error("a frame of the stream is larger than {} megapixels: shrink the frames first", MAX_PIXELS / 1_000_000)]
    TooLarge,
    /// A YUV4MPEG2 stream of a variety that is not read.
    #[error(
        "YUV4MPEG2: {0} is not read; ask for 4:2:0, 4:2:2, 4:4:4 or mono in 8 bits, as `ffmpeg -pix_fmt yuv420p` does"
    )]
    Y4m(Y4mFault),
}

/// What of a YUV4MPEG2 stream is not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Y4mFault {
    /// A header that does not end.
    #[error("a header of more than a kilobyte")]
    LongHeader,
    /// A parameter of the header.
    #[error("`{0}`")]
    Parameter(String),
    /// A header that leaves the size out.
    #[error("a header without width and height")]
    NoSize,
    /// A frame that does not begin as one.
    #[error("a frame without the word FRAME")]
    NoFrame,
}
