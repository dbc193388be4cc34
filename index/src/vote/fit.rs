//! Fitting the vote to queries whose class is known, of hands that the index does not hold: the
//! number of neighbours, the kernel's width, floor and power, all by the likelihood of the labelled
//! classes.

use super::calibration::{Calibrated, Calibration};
use super::class::shares;
use super::reliability::Reliability;
use crate::search::queries::NOISE;
use rayon::prelude::*;

/// Numbers of neighbours that are tried.
const NEIGHBOURS: [usize; 4] = [10, 20, 40, 80];
/// The most neighbours that may have a vote.
pub(crate) const MOST_VOTERS: usize = NEIGHBOURS[NEIGHBOURS.len() - 1];
/// Factors on sigma that are tried: from the nearest neighbour deciding all but alone, to all
/// having a like say.
const SCALES: [f64; 10] = [0.04, 0.06, 0.08, 0.1, 0.125, 0.16, 0.2, 0.25, 0.35, 0.5];
/// Floors that are tried.
const FLOORS: [f64; 4] = [0.003, 0.01, 0.03, 0.1];
/// Powers lie between these.
const POWERS: [f64; 2] = [0.02, 5.0];
/// Halvings of the interval that the best power lies in.
const HALVINGS: usize = 12;
/// The share of right answers that lie beyond each limit.
const TAIL: f64 = 0.005;
/// Below this many hand shapes an index represents individuals, not a population.
const MANY_HANDS: usize = 10;
/// How far queries are moved to be as strange to an index of few hands as real ones.
const FAR: [f64; 2] = [0.5, 0.9];
/// Fewer examples say nothing.
const LEAST_EXAMPLES: usize = 20;

/// A query whose class is known, and its neighbours.
#[derive(Clone, Debug)]
pub(crate) struct Example {
    /// Examples of one group look alike, and are fitted to, or measured with, together.
    pub(crate) group: u32,
    pub(crate) class: u16,
    /// Class and distance of up to [`MOST_VOTERS`] neighbours, nearest first.
    pub(crate) voters: Vec<(u16, f64)>,
}

/// How far queries that the vote is fitted to are moved, in units of sigma, for an index of this
/// many hand shapes. Chosen by the calibration error on development pictures of a hand of another
/// program: an index of 100 hand shapes comes true where queries stay as they are (0.04; 0.09 if
/// moved by [`NOISE`]), while one of a single hand is much too sure of queries from the same
/// renderer (0.21), and needs them farther away (0.07): a real hand
/// differs not only in its shape but in how it looks.
pub(crate) fn noise_of_the_vote(hand_shapes: usize) -> [f64; 2] {
    if hand_shapes < MANY_HANDS { FAR } else { [0.0, 0.1] }
}

/// The same for queries that show how far a known hand may lie: never nearer than real pictures do.
pub(crate) fn noise_of_the_farthest(hand_shapes: usize) -> [f64; 2] {
    if hand_shapes < MANY_HANDS { FAR } else { NOISE }
}

/// Fits a calibration to the even groups of the examples, which were moved by `noise`, and measures
/// it on the odd ones. `nearest` are distances at which known hands lie. Of too few examples comes
/// `otherwise`.
pub(crate) fn calibrate(
    examples: &[Example],
    nearest: impl Iterator<Item = f64>,
    classes: usize,
    sigma: f64,
    noise: [f64; 2],
    otherwise: Calibration,
) -> Calibration {
    let (fitted, measured): (Vec<&Example>, Vec<&Example>) =
        examples.iter().partition(|example| example.group % 2 == 0);
    if fitted.len().min(measured.len()) < LEAST_EXAMPLES {
        return otherwise;
    }
    let tried: Vec<(usize, f64)> =
        NEIGHBOURS.iter().flat_map(|&k| SCALES.iter().map(move |&scale| (k, scale))).collect();
    // Each by itself and in order: the same sums at any number of threads.
    let fits: Vec<(f64, Calibration)> =
        tried.par_iter().map(|&(k, scale)| fit(&fitted, classes, sigma, k, scale)).collect();
    let best = fits.into_iter().max_by(|(a, _), (b, _)| a.total_cmp(b));
    let calibration = best.map_or(otherwise, |(_, calibration)| calibration);
    let outcomes: Vec<Outcome> =
        measured.iter().map(|example| example.outcome(&calibration, classes, sigma)).collect();
    let right = outcomes.iter().filter(|outcome| outcome.is_right);
    let measured = Calibrated {
        noise,
        log_likelihood: outcomes.iter().map(|outcome| outcome.log_likelihood).sum::<f64>()
            / outcomes.len() as f64,
        reliability: Reliability::from_answers(
            outcomes.iter().map(|outcome| (outcome.probability, outcome.is_right)),
        ),
    };
    Calibration {
        farthest: quantile(nearest, 1.0 - TAIL).filter(|nearest| *nearest > 0.0),
        least_probability: quantile(right.map(|outcome| outcome.probability), TAIL).unwrap_or(0.0),
        measured: Some(measured),
        ..calibration
    }
}

/// What a calibration makes of an example.
struct Outcome {
    probability: f64,
    is_right: bool,
    /// Of the labelled class.
    log_likelihood: f64,
}

impl Example {
    fn shares(&self, classes: usize, k: usize, sigma: f64) -> Vec<f64> {
        shares(self.voters.iter().take(k).copied(), classes, sigma)
    }

    fn outcome(&self, calibration: &Calibration, classes: usize, sigma: f64) -> Outcome {
        let shares = self.shares(classes, calibration.k as usize, calibration.sigma_scale * sigma);
        let probabilities = calibration.probabilities(&shares);
        let labelled = probabilities.get(usize::from(self.class)).copied().unwrap_or(0.0);
        // The first of equals, as in a vote.
        let first = (0..).zip(&probabilities).min_by(|(_, a), (_, b)| b.total_cmp(a));
        let (class, probability) = first.map_or((0, 0.0), |(class, probability)| (class, *probability));
        Outcome {
            probability,
            is_right: class == self.class,
            log_likelihood: libm::log(labelled.max(f64::MIN_POSITIVE)),
        }
    }
}

/// The value that a share of the others lies below; `None` without values.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.get((share * values.len().saturating_sub(1) as f64).round() as usize).copied()
}

/// The best floor and power for one number of neighbours and one width, and the log-likelihood that
/// they reach.
fn fit(examples: &[&Example], classes: usize, sigma: f64, k: usize, scale: f64) -> (f64, Calibration) {
    let shares: Vec<(usize, Vec<f64>)> = examples
        .iter()
        .map(|example| (usize::from(example.class), example.shares(classes, k, scale * sigma)))
        .collect();
    let of_floor = |&floor: &f64| {
        let logs: Vec<(f64, Vec<f64>)> = shares
            .iter()
            .map(|(class, shares)| {
                let logs: Vec<f64> = shares.iter().map(|share| libm::log(share + floor)).collect();
                (logs.get(*class).copied().unwrap_or(libm::log(floor)), logs)
            })
            .collect();
        let power = best_power(&logs);
        let calibration =
            Calibration { k: k as u32, sigma_scale: scale, floor, power, ..Calibration::default() };
        (log_likelihood(&logs, power).0, calibration)
    };
    let fits = FLOORS.iter().map(of_floor);
    fits.max_by(|(a, _), (b, _)| a.total_cmp(b)).unwrap_or((f64::NEG_INFINITY, Calibration::default()))
}

/// The log-likelihood is concave in the power: its slope crosses 0 once at most.
fn best_power(logs: &[(f64, Vec<f64>)]) -> f64 {
    let [mut low, mut high] = POWERS.map(libm::log);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        let (_, slope) = log_likelihood(logs, libm::exp(middle));
        *(if slope > 0.0 { &mut low } else { &mut high }) = middle;
    }
    libm::exp((low + high) / 2.0)
}

/// The sum of `power * log of the labelled class - log of the sum over all classes`, and its slope
/// in the power.
fn log_likelihood(logs: &[(f64, Vec<f64>)], power: f64) -> (f64, f64) {
    logs.iter().fold((0.0, 0.0), |(sum_of_logs, slope), (labelled, logs)| {
        let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut mean) = (0.0, 0.0);
        for log in logs {
            let weight = libm::exp(power * (log - greatest));
            sum += weight;
            mean += weight * log;
        }
        (sum_of_logs + power * (labelled - greatest) - libm::log(sum), slope + labelled - mean / sum)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Queries whose near neighbours are of their own class three times of four, whatever the
    /// distance, and else of another.
    fn examples(count: u32) -> Vec<Example> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        (0..count)
            .map(|group| {
                let class = rng.random_range(0..3u64) as u16;
                let is_misled = rng.random_range(0.0..1.0) < 0.25;
                let near = if is_misled { (class + 1) % 3 } else { class };
                let voters = (0..MOST_VOTERS).map(|at| {
                    let other = rng.random_range(0..3u64) as u16;
                    (if at < 20 { near } else { other }, 0.1 + at as f64 * 0.01)
                });
                Example { group, class, voters: voters.collect() }
            })
            .collect()
    }

    fn fitted(count: u32) -> Calibration {
        let nearest = (0..count).map(|_| 0.1);
        calibrate(&examples(count), nearest, 3, 1.0, [0.1, 0.2], Calibration::default())
    }

    #[test]
    fn what_is_stated_comes_true() {
        let calibration = fitted(2_000);
        assert!(calibration.is_possible());
        let measured = calibration.measured.expect("there are examples enough");
        let reliability = measured.reliability;
        assert_eq!(reliability.n(), 1_000);
        assert!((reliability.accuracy().unwrap() - 0.75).abs() < 0.04, "{reliability:?}");
        assert!(reliability.expected_error().unwrap() < 0.04, "{reliability:?}");
        // The near ones agree, and are right in three cases of four: no better is possible than to
        // say so, and which of the two other classes it is else, nothing shows.
        let best = 0.75 * libm::log(0.75) + 0.25 * libm::log(0.125);
        assert!((measured.log_likelihood - best).abs() < 0.08, "{} {best}", measured.log_likelihood);
        assert_eq!(calibration.farthest, Some(0.1), "all of them have their nearest there");
        assert!((0.5..0.9).contains(&calibration.least_probability), "{calibration:?}");
    }

    #[test]
    fn the_power_is_where_the_likelihood_is_greatest() {
        let shares = [[0.6f64, 0.3, 0.1], [0.5, 0.3, 0.2], [0.2, 0.7, 0.1], [0.4, 0.35, 0.25]];
        let logs: Vec<(f64, Vec<f64>)> = shares
            .iter()
            .map(|row| (libm::log(row[0]), row.iter().map(|share| libm::log(*share)).collect()))
            .collect();
        let (best, step) = (best_power(&logs), 1.02);
        let at = |power| log_likelihood(&logs, power).0;
        assert!(at(best) >= at(best * step) && at(best) >= at(best / step), "{best}");
    }

    #[test]
    fn a_quantile_lies_between_the_shares() {
        let values = || (0..=200).rev().map(f64::from);
        assert_eq!((quantile(values(), 0.005), quantile(values(), 0.995)), (Some(1.0), Some(199.0)));
        assert_eq!(quantile(std::iter::empty(), 0.5), None);
    }

    #[test]
    fn too_few_examples_leave_the_default() {
        assert_eq!(fitted(30), Calibration::default());
        assert_eq!(fitted(0), Calibration::default());
    }
}
