//! Trains networks on renders that are drawn as it goes.
//!
//! A [`Course`] is what a network is taught: [`Hand`], of the learned descriptor, or [`Scene`],
//! which finds a hand in a camera picture or names it. [`Scenes`] are drawn by number, rendered in
//! parts, and stay in a [`Window`] for a while, out of which every batch is picked and varied anew.
//! Which parts are in the window at which step follows from the step alone ([`Schedule`]), so that
//! the trained network depends on neither the number of threads nor on how often the training was
//! stopped. It is measured on hands that no training draws.

mod check;
mod checkpoint;
mod course;
mod curve;
mod figures;
mod hand;
mod joints;
mod left_out;
mod measure;
mod options;
mod rotation;
mod run;
mod scene;
mod scenes;
mod schedule;
mod training;
mod window;

#[cfg(test)]
mod tests;

pub use check::Check;
pub use course::{Course, Lesson, Showing};
pub use curve::Row;
pub use figures::Figure;
pub use hand::Hand;
pub use left_out::LeftOut;
pub use measure::{Measured, measure};
pub use options::{DEFAULT_VALIDATE_EVERY, Kind, Optimiser, Options};
pub use run::{Files, Trained, train};
pub use scene::Scene;
pub use scenes::{DrawnScene, Scenes, StageShares};
pub use schedule::Schedule;
pub use window::Window;
