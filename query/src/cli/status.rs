//! The exit status.

/// Every input was recognised.
pub(super) const SUCCESS: u8 = 0;
/// Something failed; the message says what and what to do.
pub(super) const ERROR: u8 = 2;
/// Ctrl-C ended it, as shells count that (128 + SIGINT).
pub(super) const INTERRUPTED: u8 = 130;
