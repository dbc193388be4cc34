//! The k nearest of the rows that are measured.

use super::simd::Simd;
use super::{Neighbour, Rows};
use rayon::prelude::*;

/// Rows that are measured against one query after another while they are in the cache.
const TILE: usize = 128;

/// Keeps the k nearest rows that it is offered, nearest first, equal distances by id. A NaN counts as infinitely far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearest {
    k: usize,
    /// Ascending.
    kept: Vec<Neighbour>,
}

impl Nearest {
    pub(crate) fn new(k: usize) -> Self {
        let mut nearest = Self::default();
        nearest.reset(k);
        nearest
    }

    pub(crate) fn reset(&mut self, k: usize) {
        self.k = k;
        self.kept.clear();
    }

    /// k is small: a sorted list beats a heap.
    #[inline]
    pub(crate) fn offer(&mut self, id: u32, squared: f32) {
        // Of the NaNs, which only a damaged file can bring about, some sort before every number.
        let squared = if squared.is_nan() { f32::INFINITY } else { squared };
        // Compared as it is told: of two squares, one root may come, and what several indexes tell is merged by it.
        let offered = Neighbour { id, distance: squared.sqrt() };
        let is_before = |kept: &Neighbour| kept.by_distance(&offered).is_lt();
        if self.kept.len() >= self.k {
            if self.kept.last().is_none_or(is_before) {
                return;
            }
            self.kept.pop();
        }
        let at = self.kept.partition_point(is_before);
        self.kept.insert(at, offered);
    }

    pub(crate) fn neighbours(&self) -> impl ExactSizeIterator<Item = Neighbour> + '_ {
        self.kept.iter().copied()
    }
}

/// The k nearest of all rows.
pub(crate) fn nearest(rows: Rows<'_>, query: &[f32], k: usize) -> Vec<Neighbour> {
    let mut nearest = Nearest::new(k);
    let each = |at: usize, squared| nearest.offer(at as u32, squared);
    Simd::best().distances(query, rows.values.chunks_exact(rows.dim.max(1)), each);
    nearest.neighbours().collect()
}

/// The k nearest of all rows for each of many queries, but for the row that the query itself is. The rows are read
/// once for each thread, not once for each query.
pub(crate) fn nearest_of_many(
    rows: Rows<'_>,
    queries: &[(Option<u32>, Vec<f32>)],
    k: usize,
) -> Vec<Vec<Neighbour>> {
    let simd = Simd::best();
    let chunk = queries.len().div_ceil(rayon::current_num_threads()).max(1);
    let chunks: Vec<Vec<Vec<Neighbour>>> = queries
        .par_chunks(chunk)
        .map(|queries| {
            let mut nearest = vec![Nearest::new(k); queries.len()];
            for (start, tile) in (0u32..).step_by(TILE).zip(rows.values.chunks(TILE * rows.dim)) {
                for ((itself, query), nearest) in queries.iter().zip(&mut nearest) {
                    simd.distances(query, tile.chunks_exact(rows.dim), |at, squared| {
                        let id = start + at as u32;
                        if *itself != Some(id) {
                            nearest.offer(id, squared);
                        }
                    });
                }
            }
            nearest.iter().map(|nearest| nearest.neighbours().collect()).collect()
        })
        .collect();
    chunks.into_iter().flatten().collect()
}
