//! The exit status.

/// Everything went well.
pub const SUCCESS: u8 = 0;
/// Something failed; the message says what and what to do.
pub const ERROR: u8 = 2;
/// Ctrl-C ended it, as shells count that (128 + SIGINT).
pub const INTERRUPTED: u8 = 130;
