//! From the first event of a command to its last.

use std::time::Instant;

use grasp_terminal::PHASE;
use grasp_terminal::text::duration;
use tracing::info;

use crate::options::LogOptions;

/// Writes all events from now on, does the work of a program's command, and says when it began and
/// ended. The work returns the exit status.
pub fn run(
    options: &LogOptions,
    [program, version]: [&'static str; 2],
    command: &str,
    work: impl FnOnce() -> u8,
) -> u8 {
    options.start();
    let subject = program;
    let began = Instant::now();
    info!(target: PHASE, subject, version, state = "began", phase = command, "{command} begins");
    let status = work();
    let took = began.elapsed();
    let (time, seconds) = (duration(took), took.as_secs_f64());
    info!(target: PHASE, subject, state = "ended", phase = command, seconds, status, "{command}: {time}, status {status}");
    status
}
