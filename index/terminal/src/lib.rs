//! What both programs show a person: progress, numbers, names and errors.
//!
//! - [`Progress`] is a bar on a terminal, and an event every ten seconds in a log;
//! - [`text`] writes numbers as people do, and names of files so that a terminal is not changed by
//!   them;
//! - [`error`] writes an error and its causes, each once.

pub mod error;
mod phase;
mod progress;
pub mod text;

pub use phase::PHASE;
pub use progress::{Progress, Work};
