//! Whether to go on.

use crate::interrupt::Interrupted;

/// Asked between two pieces of work, whether the user wants it stopped.
pub type Check<'a> = &'a (dyn Fn() -> Result<(), Interrupted> + Sync);
