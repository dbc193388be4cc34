//! Where sections and the catalogue start.

/// Sections and the catalogue start at multiples of this.
pub(crate) const ALIGNMENT: u64 = 64;

/// The next multiple of [`ALIGNMENT`]; `None` past the end of `u64`.
pub(crate) fn align(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}
