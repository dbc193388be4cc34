//! The exit status.

/// Every input was recognised.
pub(super) const SUCCESS: u8 = 0;
/// Something failed; the message says what and what to do.
pub(super) const ERROR: u8 = 2;
