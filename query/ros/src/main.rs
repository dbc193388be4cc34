//! `grasp-ros`: recognises the grasp of the hand in a camera's pictures, as a node of ROS 2 that
//! needs no installed ROS.
//!
//! In order of the data: `arguments` says what to do, with `names` and `domain` where; `node` reads
//! topics and keeps the `newest` picture; `worker` makes pixels of it (`picture`), recognises it by
//! the libraries that the programs stand on, and publishes what `answer` makes of that, placed by
//! the camera's `view`. `messages` are ROS's, and `log` and `latency` say how it goes.

mod answer;
mod arguments;
mod domain;
mod latency;
mod log;
mod messages;
mod names;
mod newest;
mod node;
mod picture;
mod view;
mod worker;

use std::io::{self, Write as _};
use std::process::ExitCode;

use anyhow::Context as _;
use grasp_terminal::error::message;
use grasp_terminal::text::printable_lines;

use arguments::Arguments;

/// The exit status of whoever could not begin, or go on.
const ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments = Arguments::read(std::env::args_os().skip(1));
    let outcome = arguments.and_then(|arguments| {
        grasp_index::guard_against_truncation().context("cannot listen for faults")?;
        node::run(arguments)
    });
    let Err(error) = outcome else { return ExitCode::SUCCESS };
    if let Some(usage) = error.downcast_ref::<clap::Error>() {
        return print_usage(usage);
    }
    // Standard error may be closed; nobody is left to read it then.
    let _ = writeln!(io::stderr(), "grasp-ros: {}", message(error.chain()));
    ExitCode::from(ERROR)
}

/// Prints help, which is asked for and no error, or a usage error.
fn print_usage(usage: &clap::Error) -> ExitCode {
    let plain = usage.render().to_string();
    let safe = printable_lines(&plain);
    let printed = if safe == plain { usage.print() } else { io::stderr().write_all(safe.as_bytes()) };
    let is_error =
        usage.use_stderr() || printed.is_err_and(|problem| problem.kind() != io::ErrorKind::BrokenPipe);
    if is_error { ExitCode::from(ERROR) } else { ExitCode::SUCCESS }
}
