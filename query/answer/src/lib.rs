//! Answers as programs and people get them: a [`record`] of an input, or [`found`] entries of raw
//! descriptors, as JSON; the same as text by [`human`], as a message for MoveIt by [`moveit`], and
//! as a drawing of how it came about by [`explain`]. [`annotate`] draws answers into the frames of
//! a video, and [`lettering`] puts text on pictures. [`index_file`] is which index they come from.
//!
//! The program and the service print the same, and so the records stand below both. The feature
//! `schema` describes them for OpenAPI; it is off by default.

pub mod annotate;
mod canvas;
mod drawn;
pub mod explain;
pub mod found;
pub mod human;
pub mod index_file;
pub mod lettering;
pub mod moveit;
pub mod record;
