//! Numbers that look random and are the same in every run.

use xxhash_rust::xxh3::xxh3_64_with_seed;

/// A row of numbers that follows from its seed.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    seed: u64,
    count: u64,
}

impl Draws {
    /// The row of a picture's `name`, and of a number where there are several of that name.
    pub(super) fn of(name: &str, number: usize) -> Self {
        Self { seed: xxh3_64_with_seed(name.as_bytes(), number as u64), count: 0 }
    }

    fn next(&mut self) -> u64 {
        self.count += 1;
        xxh3_64_with_seed(&self.count.to_le_bytes(), self.seed)
    }

    /// Evenly from `from` to `to`.
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// One of `count` numbers from 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    /// About normally, with mean 0 and this deviation: the sum of four even draws.
    pub(super) fn about(&mut self, deviation: f64) -> f64 {
        let sum: f64 = (0..4).map(|_| self.between(-1.0, 1.0)).sum();
        sum * deviation * 0.75f64.sqrt()
    }
}
