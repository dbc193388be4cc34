//! Trains the network behind the learned descriptor on renders that are drawn as it goes.
//!
//! [`Scenes`] are drawn by number, rendered in parts, and stay in a [`Window`] for a while, out of
//! which every batch is picked and varied anew ([`Sample`], `augment`). Which parts are in the
//! window at which step follows from the step alone ([`Schedule`]), so that the trained network
//! depends on neither the number of threads nor on how often the training was stopped.
//! [`Validation`] measures on hands that no training draws.

mod augment;
mod check;
mod checkpoint;
mod curve;
mod options;
mod run;
mod sample;
mod scenes;
mod schedule;
mod training;
mod validation;
mod window;

#[cfg(test)]
mod tests;

pub use check::Check;
pub use curve::Row;
pub use options::{DEFAULT_SAMPLES, DEFAULT_SEED, DEFAULT_VALIDATE_EVERY, Options};
pub use run::{Files, Trained, train};
pub use sample::{Labels, Sample, Shown};
pub use scenes::Scenes;
pub use schedule::Schedule;
pub use validation::{Figures, Validation};
pub use window::{Window, render};
