//! From the weights' shares to probabilities, and where an answer stops being one.
//!
//! The share that a class has of Equation 3's weights says how much the neighbours agree, not how
//! often they are right. With a floor `a` and a power `g`, both fitted to hands that the index does
//! not hold ([`super::calibrate`]), the probability is
//!
//! ```text
//! P(c) = (share(c) + a)^g / sum over all classes of the same
//! ```

use super::reliability::Reliability;
use thiserror::Error;

/// More neighbours cost time without changing the vote.
const MOST_NEIGHBOURS: u32 = 100_000;

/// How neighbours are best weighed, and what their agreement is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How many neighbours vote.
    pub k: u32,
    /// The factor on [`crate::Sigma::mean_distance`] that makes the kernel's width.
    pub sigma_scale: f64,
    /// Added to each class's share of the weights, 0 or more.
    pub floor: f64,
    /// The power that turns shares into probabilities, above 0; with 1 and no floor, they are the
    /// shares.
    pub power: f64,
    /// The distance of the nearest neighbour, beyond which there is no answer: 1 known hand in 200
    /// lies farther. `None` where that is not known.
    pub farthest: Option<f64>,
    /// The probability of the first class, 0 to 1, below which there is no answer: 1 right answer
    /// in 200 is less sure.
    pub least_probability: f64,
    /// How it was fitted; `None` where it is not, and `probability` is the share of the weights.
    pub measured: Option<Calibrated>,
}

/// What a calibration was fitted to, and how well it fits on queries that it was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// How far the queries were moved, in units of sigma: least and most.
    pub noise: [f64; 2],
    /// The mean logarithm of the labelled class's probability.
    pub log_likelihood: f64,
    /// How often answers of each probability were right.
    pub reliability: Reliability,
}

/// Why neighbours make no answer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Doubt {
    /// There is nothing alike in the index.
    #[error("the nearest entry lies {distance:.3} away, and known hands lie within {farthest:.3}")]
    TooFar {
        /// The distance of the nearest neighbour.
        distance: f64,
        /// The farthest that is taken for known.
        farthest: f64,
    },
    /// No class stands out.
    #[error("the most probable class has {probability:.2}, and right answers have {least:.2} at least")]
    TooUnsure {
        /// The probability of the first class.
        probability: f64,
        /// The least that is taken for an answer.
        least: f64,
    },
}

impl Default for Calibration {
    /// Ten neighbours, the width of Equation 5, shares as they are, and always an answer.
    fn default() -> Self {
        Self {
            k: 10,
            sigma_scale: 1.0,
            floor: 0.0,
            power: 1.0,
            farthest: None,
            least_probability: 0.0,
            measured: None,
        }
    }
}

impl Calibration {
    /// Whether the numbers lie in their ranges.
    pub(crate) fn is_possible(&self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        (1..=MOST_NEIGHBOURS).contains(&self.k)
            && positive(self.sigma_scale)
            && positive(self.power)
            && self.floor.is_finite()
            && self.floor >= 0.0
            && self.farthest.is_none_or(positive)
            && (0.0..=1.0).contains(&self.least_probability)
            && self.measured.as_ref().is_none_or(|measured| {
                measured.log_likelihood.is_finite()
                    && measured.log_likelihood <= 0.0
                    && measured.reliability.is_possible()
            })
    }

    /// What speaks against an answer, whose nearest neighbour lies at `nearest` and whose first
    /// class has `probability`.
    pub fn doubt(&self, nearest: f64, probability: f64) -> Option<Doubt> {
        let least = self.least_probability;
        match self.farthest {
            Some(farthest) if nearest > farthest => Some(Doubt::TooFar { distance: nearest, farthest }),
            _ => (probability < least).then_some(Doubt::TooUnsure { probability, least }),
        }
    }

    /// The probabilities that the classes' shares of the weights mean.
    pub(crate) fn probabilities(&self, shares: &[f64]) -> Vec<f64> {
        if self.floor == 0.0 && self.power == 1.0 {
            return shares.to_vec();
        }
        let greatest = shares.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        // Relative to the greatest, so that no power makes nothing of all of them.
        let raised: Vec<f64> = shares
            .iter()
            .map(|share| libm::pow((share + self.floor) / (greatest + self.floor), self.power))
            .collect();
        let sum: f64 = raised.iter().sum();
        raised.iter().map(|value| value / sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn probabilities_sum_to_1_and_keep_the_order(
            weights in prop::collection::vec(0.0..1.0f64, 1..8), floor in 0.0..0.5f64, power in 0.01..9.0f64
        ) {
            let sum: f64 = weights.iter().sum::<f64>().max(1e-9);
            let shares: Vec<f64> = weights.iter().map(|weight| weight / sum).collect();
            let calibration = Calibration { floor, power, ..Calibration::default() };
            let probabilities = calibration.probabilities(&shares);
            prop_assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{probabilities:?}");
            for (a, b) in (0..shares.len()).flat_map(|a| (0..shares.len()).map(move |b| (a, b))) {
                prop_assert!(shares[a] > shares[b] || probabilities[a] <= probabilities[b]);
            }
        }
    }

    #[test]
    fn without_floor_and_power_they_are_the_shares() {
        let shares = [0.1, 0.7, 0.2];
        assert_eq!(Calibration::default().probabilities(&shares), shares);
    }

    #[test]
    fn beyond_a_limit_there_is_doubt() {
        let calibration =
            Calibration { farthest: Some(0.5), least_probability: 0.25, ..Calibration::default() };
        assert_eq!(calibration.doubt(0.5, 0.25), None);
        assert_eq!(calibration.doubt(0.6, 0.9), Some(Doubt::TooFar { distance: 0.6, farthest: 0.5 }));
        assert_eq!(calibration.doubt(0.1, 0.2), Some(Doubt::TooUnsure { probability: 0.2, least: 0.25 }));
        assert_eq!(Calibration::default().doubt(f64::INFINITY, 0.0), None);
    }

    #[test]
    fn by_hand() {
        // (0.5 + 0.25)^2 to (0.25 + 0.25)^2 twice: 0.5625 to 0.25 to 0.25.
        let calibration = Calibration { floor: 0.25, power: 2.0, ..Calibration::default() };
        let probabilities = calibration.probabilities(&[0.5, 0.25, 0.25]);
        assert!((probabilities[0] - 0.5625 / 1.0625).abs() < 1e-12, "{probabilities:?}");
    }
}
