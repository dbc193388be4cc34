//! Camera pictures: a hand with its arm and the thing that it holds, in colour, before a
//! background, as a camera sees them.
//!
//! A [`PosedHand`] is meshed once and dressed as often as is wanted, each time on another arm and
//! with another thing, in a [`CameraScene`]; [`Layers`] are what one view of it shows: the part,
//! the normal and the place on the part of every texel. [`Layers::paint`] makes pictures of them,
//! as many as are wanted, each with a random [`Framing`], skin, materials, background, light and
//! optics: what a picture of a stranger's hand in a stranger's room may look like.

mod background;
mod border;
mod clutter;
mod dressed;
mod lattice;
mod layers;
mod light;
mod marks;
mod optics;
mod paint;
mod palette;
mod randomised;
mod shading;
mod shut;
mod surface;
mod things;
mod wrist;

pub use dressed::{CameraScene, PosedHand};
pub use layers::{Framing, Layers};
pub use paint::{Part, Picture};
pub use randomised::Randomised;
