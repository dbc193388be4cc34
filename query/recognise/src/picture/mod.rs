//! Pictures: what a camera gives, decoded to RGB.

mod decode;
mod folder;
mod rgb;

pub use decode::{Decoded, decode, decode_grey, decode_grey16};
pub use folder::{PicturesIn, pictures_in};
pub use grasp_picture::{
    DecodeError, DecodeWarning, FORMATS, Frame, Frames, MAX_PIXELS, StreamError, dimensions, read,
};
pub use rgb::Picture;

/// The longest side, in pixels, that segmentation works on; larger pictures are averaged down
/// first.
///
/// A descriptor sees a hand through a grid of 8 x 8 cells, so more pixels cost time and change
/// nothing.
pub const WORKING_SIDE: usize = 512;
