//! A moment between entries.

use crate::interrupt;

/// Entries between two calls of the callback.
const STEP: u64 = 1 << 12;

/// Reports, every now and then, that `at` entries were written, and ends the work where the user
/// asked to stop.
pub(super) fn pause(at: u64, wrote: &dyn Fn(u64)) -> anyhow::Result<()> {
    if at.is_multiple_of(STEP) {
        wrote(at);
        interrupt::check()?;
    }
    Ok(())
}
