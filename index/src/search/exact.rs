//! The k nearest of the rows that are measured.

use super::{Neighbour, Rows, distance};

/// Keeps the k nearest rows that it is offered, nearest first, equal distances by id. A NaN counts as infinitely far.
#[derive(Debug)]
pub(crate) struct Nearest {
    k: usize,
    /// Squared distances and ids, ascending.
    kept: Vec<(f32, u32)>,
}

impl Nearest {
    pub(crate) fn new(k: usize) -> Self {
        Self { k, kept: Vec::with_capacity(k.min(1024)) }
    }

    /// k is small: a sorted list beats a heap.
    #[inline]
    pub(crate) fn offer(&mut self, id: u32, squared: f32) {
        // Of the NaNs, which only a damaged file can bring about, some sort before every number.
        let squared = if squared.is_nan() { f32::INFINITY } else { squared };
        let is_before = |kept: &(f32, u32)| kept.0.total_cmp(&squared).then(kept.1.cmp(&id)).is_lt();
        if self.kept.len() >= self.k {
            if self.kept.last().is_none_or(is_before) {
                return;
            }
            self.kept.pop();
        }
        let at = self.kept.partition_point(is_before);
        self.kept.insert(at, (squared, id));
    }

    pub(crate) fn into_neighbours(self) -> Vec<Neighbour> {
        self.kept.into_iter().map(|(squared, id)| Neighbour { id, distance: squared.sqrt() }).collect()
    }
}

/// The k nearest of all rows, `except` one.
pub(crate) fn nearest(rows: Rows<'_>, query: &[f32], k: usize, except: Option<u32>) -> Vec<Neighbour> {
    let mut nearest = Nearest::new(k);
    for (id, row) in (0u32..).zip(rows.values.chunks_exact(rows.dim.max(1))) {
        if Some(id) != except {
            nearest.offer(id, distance::squared(query, row));
        }
    }
    nearest.into_neighbours()
}
