//! Neighbours, and the k nearest of them.

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
    k: usize,
    /// Ascending.
    kept: Vec<Neighbour>,
    /// No squared distance above is among the nearest; some that are below it are not either.
    bound: f32,
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
        self.bound = f32::INFINITY;
    }

    /// k is small: a sorted list beats a heap.
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
        if let (true, Some(last)) = (self.kept.len() >= self.k, self.kept.last()) {
            // A root is rounded by less than that.
            let squared = f64::from(last.distance).powi(2) * (1.0 + 1e-6);
            self.bound = squared as f32;
        }
    }

    pub(crate) fn neighbours(&self) -> impl ExactSizeIterator<Item = Neighbour> + '_ {
        self.kept.iter().copied()
    }
}
