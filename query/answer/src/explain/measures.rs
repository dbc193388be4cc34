//! The measures of the sheet, in pixels.

pub(super) const MARGIN: u32 = 24;
/// Between two pictures that lie side by side.
pub(super) const GAP: u32 = 12;
/// Side of the pictures at the top, of which there are three, with the vote beside them.
pub(super) const LARGE: u32 = 300;
pub(super) const WIDTH: u32 = 2 * MARGIN + 4 * LARGE + 3 * GAP;
