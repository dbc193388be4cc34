//! What cannot fail.

use std::io;

use plotters::drawing::DrawingAreaErrorKind;

/// What was drawn: a drawing grows in memory, where nothing fails.
pub(crate) fn sure<T>(drawn: Result<T, DrawingAreaErrorKind<io::Error>>) -> T {
    drawn.expect("a drawing grows in memory")
}
