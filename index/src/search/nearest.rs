//! Neighbours, and the k nearest of them.

use super::smallest::Smallest;

/// One entry of the index, as near as `distance` to the query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// The entry's number in the index.
    pub id: u32,
    /// The Euclidean distance between the descriptors.
    pub distance: f32,
}

impl Neighbour {
    /// Nearest first; equal distances by id.
    pub(crate) fn by_distance(&self, other: &Self) -> std::cmp::Ordering {
        self.distance.total_cmp(&other.distance).then(self.id.cmp(&other.id))
    }
}

/// Keeps the k nearest rows that it is offered, nearest first, equal distances by id. A NaN counts
/// as infinitely far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearest {
    kept: Smallest,
    /// No row whose squared distance is above is among the nearest.
    bound: f32,
}

impl Nearest {
    pub(crate) fn new(k: usize) -> Self {
        let mut nearest = Self::default();
        nearest.reset(k);
        nearest
    }

    /// `k`: at least 1.
    pub(crate) fn reset(&mut self, k: usize) {
        self.kept.reset(k);
        self.bound = f32::INFINITY;
    }

    /// Offers a row by the square of its distance.
    #[inline]
    pub(crate) fn offer(&mut self, id: u32, squared: f32) {
        // Most are too far, and need no root to show it.
        if squared > self.bound {
            return;
        }
        // Of the NaNs, which only a damaged file can bring about, some sort before every number.
        let squared = if squared.is_nan() { f32::INFINITY } else { squared };
        // Compared as it is returned: of two squares, one root may come, and what several indexes
        // return is merged by it.
        if self.kept.push(squared.sqrt(), id) {
            // A root is rounded by less than that.
            self.bound = (f64::from(self.kept.bound()).powi(2) * (1.0 + 1e-6)) as f32;
        }
    }

    /// What was kept, nearest first.
    pub(crate) fn neighbours(&mut self) -> impl ExactSizeIterator<Item = Neighbour> + '_ {
        self.kept.sorted().map(|(distance, id)| Neighbour { id, distance })
    }
}
