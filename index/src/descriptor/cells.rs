//! The cells of a descriptor.

use super::params::{DescriptorKind, DescriptorParams};

/// One cell of a descriptor: where it lies and its histogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<'a> {
    /// The paper's l, from 1 (finest) to L (the whole picture).
    pub level: u32,
    /// How many cells the level has a side: `2^(L-l)`.
    pub cells_a_side: usize,
    /// The cell's row, from the top.
    pub row: usize,
    /// The cell's column, from the left.
    pub column: usize,
    /// The values of the `B` bins.
    pub histogram: &'a [f32],
}

impl DescriptorParams {
    /// The cells of a descriptor, finest level first, each level row by row: what the paper's
    /// Figure 4 draws. Only a pyramid has any.
    pub fn cells<'a>(&self, descriptor: &'a [f32]) -> impl Iterator<Item = Cell<'a>> {
        let is_pyramid = matches!(self.kind, DescriptorKind::Paper | DescriptorKind::Default);
        // Of parameters out of range there is no descriptor.
        let has_cells = is_pyramid && self.validate().is_ok();
        let params = if has_cells { *self } else { Self { levels: 0, bins: 1, ..*self } };
        let places = (1..=params.levels).flat_map(move |level| {
            let cells_a_side = 1usize << (params.levels - level);
            (0..cells_a_side * cells_a_side).map(move |cell| (level, cells_a_side, cell))
        });
        places.zip(descriptor.chunks_exact(params.bins as usize)).map(
            |((level, cells_a_side, cell), histogram)| Cell {
                level,
                cells_a_side,
                row: cell / cells_a_side,
                column: cell % cells_a_side,
                histogram,
            },
        )
    }
}
