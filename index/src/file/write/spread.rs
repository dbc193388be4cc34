//! How far the descriptors of an index lie apart. Distances are sums of squares: those of smaller
//! differences round to nothing, and every entry would be as near as every other.

use crate::file::input::BuildError;
use crate::search::Originals;
use half::f16;

/// Of differences that are a ten-millionth of this, which is as little as an f32 tells apart, the
/// squares have all their digits yet.
const LEAST: f32 = 1e-12;

/// How far descriptors lie apart, as they come.
#[derive(Clone, Debug, Default)]
pub(super) struct Spread {
    first: Vec<f32>,
    /// The largest difference of a value from the first descriptor's; 0 where all are equal.
    largest: f32,
}

impl Spread {
    /// Takes a descriptor into account, as long as all others.
    pub(super) fn add(&mut self, descriptor: &[f32]) {
        if self.first.is_empty() {
            self.first.extend(descriptor);
        }
        let apart = self.first.iter().zip(descriptor).map(|(first, value)| (value - first).abs());
        self.largest = apart.fold(self.largest, f32::max);
    }

    /// Whether distances between them can be told apart, in the form in which they are kept.
    pub(super) fn check(&self, originals: Originals) -> Result<(), BuildError> {
        let is_between_nothing_and = |least: f32| self.largest > 0.0 && self.largest < least;
        if is_between_nothing_and(LEAST) {
            return Err(BuildError::Params(
                "the descriptors differ by less than 1e-12, too little to measure distances by: multiply all descriptors by the same number",
            ));
        }
        // Below the least number that has all its digits.
        if originals == Originals::F16 && is_between_nothing_and(f16::MIN_POSITIVE.to_f32()) {
            return Err(BuildError::Params(
                "the descriptors differ by less than 6e-5, too little for 16 bits: keep the originals as f32, or multiply all descriptors by the same number",
            ));
        }
        Ok(())
    }
}
