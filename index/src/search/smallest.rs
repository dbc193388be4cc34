//! The few smallest of many scores.

use super::blocks::{Block, LANES};

/// Keeps the `keep` smallest of the scores that it is offered, equal ones by number. What is kept
/// does not depend on the order of the offers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Smallest {
    keep: usize,
    /// Scores and numbers, packed so that they compare as integers.
    keys: Vec<u64>,
    /// No score above is among the smallest.
    bound: f32,
}

impl Smallest {
    pub(crate) fn reset(&mut self, keep: usize) {
        self.keep = keep.max(1);
        self.keys.clear();
        self.bound = f32::MAX;
    }

    /// No score above is among the smallest.
    #[inline]
    pub(crate) fn bound(&self) -> f32 {
        self.bound
    }

    /// Offers those vectors of a block whose bit is set in `mask`.
    #[inline]
    pub(crate) fn offer(&mut self, block: &Block<'_>, scores: &[f32; LANES], mut mask: u16) {
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            self.push(scores[lane % LANES], block.id(lane));
        }
    }

    /// Offers a score, which is no NaN. Returns whether the bound has moved.
    #[inline]
    pub(crate) fn push(&mut self, score: f32, number: u32) -> bool {
        self.keys.push(u64::from(ordered(score)) << 32 | u64::from(number));
        let is_full = self.keys.len() >= self.keep.saturating_mul(2).saturating_add(16);
        if is_full {
            self.shrink();
        }
        is_full
    }

    fn shrink(&mut self) {
        if self.keys.len() > self.keep {
            let (_, &mut last, _) = self.keys.select_nth_unstable(self.keep - 1);
            self.keys.truncate(self.keep);
            self.bound = score(last);
        }
    }

    /// What was kept, smallest first: scores and numbers.
    pub(crate) fn sorted(&mut self) -> impl ExactSizeIterator<Item = (f32, u32)> + Clone + '_ {
        self.shrink();
        self.keys.sort_unstable();
        self.keys.iter().map(|&key| (score(key), key as u32))
    }

    /// How many are kept at most.
    pub(crate) fn keep(&self) -> usize {
        self.keep
    }

    /// What was kept, in no order: integers that compare as the scores do, and numbers.
    pub(crate) fn keys(&mut self) -> impl ExactSizeIterator<Item = (u32, u32)> + '_ {
        self.shrink();
        self.keys.iter().map(|&key| ((key >> 32) as u32, key as u32))
    }

    /// What was kept, in no order.
    pub(crate) fn unsorted(&mut self) -> impl ExactSizeIterator<Item = (f32, u32)> + Clone + '_ {
        self.shrink();
        self.keys.iter().map(|&key| (score(key), key as u32))
    }
}

/// Integers that compare as the scores do.
#[inline]
fn ordered(score: f32) -> u32 {
    let bits = score.to_bits();
    bits ^ (((bits as i32 >> 31) as u32) | 1 << 31)
}

#[inline]
fn score(key: u64) -> f32 {
    let bits = (key >> 32) as u32;
    f32::from_bits(bits ^ ((!(bits as i32 >> 31) as u32) | 1 << 31))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn keeps_what_sorting_puts_first(scores in prop::collection::vec(prop_oneof![-3.0..3.0f32, Just(0.0), Just(1.0), Just(f32::NAN), Just(f32::INFINITY)], 0..300), keep in 1..40usize) {
            let mut smallest = Smallest::default();
            smallest.reset(keep);
            for (&score, at) in scores.iter().zip(0..) {
                if score <= smallest.bound() {
                    smallest.push(score, at);
                }
            }
            let mut expected: Vec<(f32, u32)> =
                scores.iter().zip(0..).filter(|(score, _)| score.is_finite()).map(|(&score, at)| (score, at)).collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            expected.truncate(keep);
            prop_assert_eq!(smallest.sorted().collect::<Vec<_>>(), expected);
        }
    }
}
