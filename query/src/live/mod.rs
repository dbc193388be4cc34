//! Frames as they come: of a camera, of streams in files, or of a pipe.
//!
//! A [`Source`] gives one encoded frame after the other. [`Ahead`] reads it on a thread of its own,
//! and either waits for whoever takes the frames or, for what cannot wait, keeps the newest only.
//! [`Pace`] says how long the work on them took.

mod ahead;
pub mod camera;
mod pace;
mod source;

pub use ahead::{Ahead, Frame, Keep};
pub use pace::Pace;
pub use source::{EncodedFrame, STANDARD_INPUT, Source, SourceError, Streams};
