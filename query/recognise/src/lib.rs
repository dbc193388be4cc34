//! Recognises the grasp of a hand in a picture by an index of known views.
//!
//! In order of the data: [`picture`] decodes what a camera gives, [`segment`] finds the hand in it
//! (the paper's Section III), a [`Recogniser`] describes the hand, searches the index and lets the
//! neighbours vote (Sections IV and V), [`sequence`] and [`prior`] add what earlier frames and the
//! object say, and [`orientation`] puts the hand's rotation into words.
//!
//! The feature `schema` describes the types that stand in records for OpenAPI; it is off by default.

pub mod orientation;
pub mod picture;
pub mod prior;
mod recognise;
pub mod segment;
pub mod sequence;

pub use recognise::{
    Accept, DEFAULT_ROLLS, Doubt, Evidence, HandChoice, Hypothesis, Logistic, MaskSource, Prepared,
    RecogniseError, RecogniseOptions, Recogniser, Recognition, Side, SourceError, Term, Timings, Trust,
    Warning, logistic, temper,
};
