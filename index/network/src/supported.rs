//! What is reported where an architecture asks for too much.

use thiserror::Error;

/// An architecture that is not supported.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("unsupported network: the {what} is {value}, where {supported}")]
pub struct ArchitectureError {
    /// Which number is out of range.
    pub what: &'static str,
    /// The number.
    pub value: u64,
    /// What is supported.
    pub supported: &'static str,
}

pub(crate) fn check(
    holds: bool,
    value: u64,
    what: &'static str,
    supported: &'static str,
) -> Result<(), ArchitectureError> {
    if holds { Ok(()) } else { Err(ArchitectureError { what, value, supported }) }
}
