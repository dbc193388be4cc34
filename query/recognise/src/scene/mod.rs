//! Finds a hand in a camera picture, and names its grasp, by four networks that were trained on
//! scenes of our own renders (`grasp-builder train --kind scene`, `naming`, `thing` and `mask`).
//!
//! A network looks at a [`Square`] of the picture. [`find`] looks at the whole picture first, then
//! at the square around the hand that it has found there, turned so that the arm comes from below,
//! as in the scenes that it learned to name grasps by. There the mask network sees what is hand,
//! arm and thing. This [`Detection`] helps colours to cut the hand out, which two networks then
//! look at once more, and another at what it holds: a [`Scene`] says which hand it is, and how
//! likely each grasp is by all that is seen, by which the neighbours are weighed.

mod arm;
mod cut_out;
mod find;
mod join;
#[cfg(feature = "landmarks")]
mod joints;
mod landmarks;
mod look;
mod masks;
mod opening;
mod patch;
mod prediction;
mod seen;
mod square;

#[cfg(feature = "landmarks")]
pub use find::find_by_joints;
pub use find::{Detection, find, find_at, follow};
pub(crate) use join::join_orientation;
pub use landmarks::{Joints, LandmarkUnit, Landmarks, LandmarksError};
pub use opening::Opening;
pub use prediction::Prediction;
pub use seen::Scene;
pub use square::{Map, Square};
