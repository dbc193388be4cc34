//! Where the programs' messages go: lines for people, or an object of JSON a line, on standard
//! error.
//!
//! Everything else emits events by the `tracing` crate and knows no subscriber; the programs call
//! [`run`] once. Three conventions make a sentence for people and a record for machines of the same
//! event:
//!
//! - `message` is a whole sentence and stands for itself: lines for people show no other field,
//!   but for what follows;
//! - `subject` is what the message is about: the program, a file, a line of a table. Where there is
//!   one, a line for people is `subject: message`;
//! - events of the target [`PHASE`] say when a piece of work begins and ends. They are of use to a
//!   collector of logs; people see them from the level `debug` on.
//!
//! [`PHASE`]: grasp_terminal::PHASE

mod command;
mod form;
mod level;
mod lines;
mod options;
mod panic;

pub use command::run;
pub use form::LogForm;
pub use level::LogLevel;
pub use options::{GLOBAL, LogOptions};
