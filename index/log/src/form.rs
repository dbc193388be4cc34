//! How messages are written.

/// How messages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum LogForm {
    /// Lines for people.
    #[default]
    Text,
    /// An object a line, with `timestamp`, `level`, `message`, `target` and what else is known.
    Json,
}
