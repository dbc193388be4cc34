//! The few smallest of many scores.

use super::blocks::{Blocks, LANES, QuantisedQuery};
use super::simd::Simd;

/// So many scores are looked at together, or those of one run, where it has more.
const TOGETHER: usize = 8192;
/// How often the range of a first bound is halved.
const HALVINGS: usize = 7;

/// Keeps the `keep` smallest of the scores that it is offered, equal ones by number. What is kept
/// does not depend on the order of the offers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Smallest {
    keep: usize,
    /// Scores and numbers, packed so that they compare as integers.
    keys: Vec<u64>,
    /// No score above is among the smallest.
    bound: f32,
    /// Of [`Self::scan`]: scores as they lie in their blocks, the least of some of them each, and
    /// the places of those that may be among the smallest.
    scores: Vec<f32>,
    least: Vec<f32>,
    near: Vec<u32>,
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

    /// Offers the vectors of all `runs` by their scores ([`Simd::scan`]), each run with its base,
    /// and under their numbers: ids, or, where blocks hold none, places among all blocks.
    pub(crate) fn scan<'b>(
        &mut self,
        simd: Simd,
        mut runs: impl Iterator<Item = (f32, Blocks<'b>)> + Clone,
        query: &QuantisedQuery,
        factor: f32,
    ) {
        loop {
            let scanned = runs.clone();
            self.scores.clear();
            while self.scores.len() < TOGETHER
                && let Some((base, run)) = runs.next()
            {
                let start = self.scores.len();
                self.scores.resize(start + LANES * run.len(), f32::INFINITY);
                simd.scan(run, query, factor, base, &mut self.scores[start..]);
            }
            if self.scores.is_empty() {
                return;
            }
            self.lower_bound();
            simd.near(&self.scores, self.bound, &mut self.near);
            self.offer(scanned.map(|(_, run)| run));
        }
    }

    /// Finds a first bound, so that few scores are offered in vain. Scores are put into twice as
    /// many groups as are kept; a bound that the least of half the groups do not exceed will do.
    fn lower_bound(&mut self) {
        if self.bound < f32::MAX || self.scores.len() / 4 < self.keep {
            return;
        }
        self.least.clear();
        self.least.resize((2 * self.keep).next_multiple_of(LANES), f32::MAX);
        for scores in self.scores.chunks(self.least.len()) {
            for (least, &score) in self.least.iter_mut().zip(scores) {
                *least = if score < *least { score } else { *least };
            }
        }
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for &least in &self.least {
            low = if least < low { least } else { low };
            high = if least > high { least } else { high };
        }
        // Halving the range is quicker than sorting, and a bound may be a little too high.
        for _ in 0..HALVINGS {
            let middle = low + 0.5 * (high - low);
            let below: u32 = self.least.iter().map(|&least| u32::from(least <= middle)).sum();
            if below as usize >= self.keep {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.bound = high.min(f32::MAX);
    }

    /// Offers the scores at the places that are near.
    fn offer<'b>(&mut self, mut runs: impl Iterator<Item = Blocks<'b>>) {
        let near = std::mem::take(&mut self.near);
        let (mut run, mut start, mut end) = (None, 0, 0);
        for &place in &near {
            let place = place as usize;
            while place >= end
                && let Some(next) = runs.next()
            {
                (start, end) = (end, end + LANES * next.len());
                run = Some(next);
            }
            let number = run.and_then(|run| run.number(place - start));
            if let (Some(number), Some(&score)) = (number, self.scores.get(place)) {
                self.push(score, number);
            }
        }
        self.near = near;
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
