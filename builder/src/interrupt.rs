//! Ctrl-C: long work looks at one flag between two pieces and stops cleanly.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// Set by the first SIGINT or SIGTERM.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The work was stopped by the user. What is kept of it, and how to go on, depends on the work.
#[derive(Debug, thiserror::Error)]
#[error("stopped")]
pub struct Interrupted;

/// Catches SIGINT and SIGTERM from now on. A second signal ends the program at once.
///
/// # Errors
/// If the handler cannot be installed.
pub fn catch() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(grasp_program::status::INTERRUPTED));
        }
    })
    .context("cannot listen for Ctrl-C")
}

/// The flag itself, for work that takes a flag to look at.
pub fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}

/// `Err(Interrupted)` once the user has asked to stop.
///
/// # Errors
/// [`Interrupted`], and no other.
pub fn check() -> Result<(), Interrupted> {
    if INTERRUPTED.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
}

/// [`check`] for work that is asked at each step whether it goes on.
pub fn flow() -> ControlFlow<()> {
    if check().is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
