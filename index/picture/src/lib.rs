//! Encoded pictures, and streams of them, to pixels within limits of memory and time.
//!
//! Whoever sends a picture chooses its bytes, so what a decoder does must follow from the pixels
//! that are asked for, not from what a file claims or unpacks to. Three rules give that:
//!
//! - The header is checked before anything is decoded: at most [`MAX_PIXELS`] pixels, at most
//!   [`MAX_SIDE`] a side, and at most [`MAX_BYTES_A_PIXEL`] encoded bytes a pixel
//!   ([`MAX_COMPRESSED_BYTES_A_PIXEL`] in JPEG, WebP and GIF) and [`MAX_OVERHEAD`] besides.
//! - A decoder is given only what pixels follow from. Colour profiles, text, thumbnails and the
//!   later frames of an animation are skipped by length and never unpacked; of EXIF, only the
//!   orientation is read.
//! - Where a format allows any number of passes over the pixels, they are bounded (a JPEG's scans:
//!   [`MAX_SCANS`]), and what cannot be bounded is not read (see [`FORMATS`]).
//!
//! Together they keep the memory of one picture, its encoded bytes included, below 20 bytes a pixel
//! and 64 MiB, and its time proportional to its pixels and its encoded bytes. A frame of a stream
//! is gathered to its end first: up to as many bytes as the largest picture has in 16 bits a
//! channel.
//!
//! This crate knows nothing of hands, indexes or services: the offline and the online programs read
//! their pictures by it.

mod decode;
mod error;
mod file;
mod format;
mod jpeg;
mod limits;
mod pieces;
mod png;
mod size;
mod stream;
mod webp;
mod yuv;

pub use decode::{Decoded, decode, dimensions};
pub use error::{DecodeError, DecodeWarning};
pub use file::read;
pub use format::Format;
pub use image::metadata::Orientation;
pub use jpeg::MAX_MISSING_PERCENT;
pub use limits::{
    FORMATS, MAX_BYTES_A_PIXEL, MAX_COMPRESSED_BYTES_A_PIXEL, MAX_OVERHEAD, MAX_PIXELS, MAX_SCANS, MAX_SIDE,
};
pub use stream::{Frame, Frames, StreamError, Y4mFault};
pub use yuv::yuyv_to_pnm;
