//! What the command lines of both programs share: the options that every subcommand understands,
//! the way from the command line to the exit status, manual pages, and completions.

mod completions;
mod global;
mod man;
mod output_file;
mod start;
pub mod status;

pub use completions::Completions;
pub use global::Global;
pub use man::Man;
pub use output_file::output_file;
pub use start::start;
