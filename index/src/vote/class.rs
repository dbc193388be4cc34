//! Equation 3: every neighbour votes for its class with the weight `exp(-d^2 / (2 sigma^2))`.

use super::Ballot;

/// The smallest sigma that is divided by: an index of equal descriptors has sigma 0.
const MIN_SIGMA: f64 = 1e-12;

/// The logarithm of a neighbour's weight.
fn log_weight(distance: f64, sigma: f64) -> f64 {
    let scaled = distance / sigma.max(MIN_SIGMA);
    -0.5 * scaled * scaled
}

/// The weights of the ballots, divided by the greatest: far from everything all of them would round to 0, and their
/// ratios, which is what counts, with them.
pub(super) fn relative_weights(ballots: &[Ballot], sigma: f64) -> Vec<f64> {
    let logs: Vec<f64> = ballots.iter().map(|ballot| log_weight(ballot.distance, sigma)).collect();
    let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    logs.iter().map(|log| if greatest.is_finite() { (log - greatest).exp() } else { 1.0 }).collect()
}

/// Each class's share of the weights. Without ballots every class has the same.
pub(crate) fn probabilities(ballots: &[Ballot], classes: usize, sigma: f64) -> Vec<f64> {
    let mut shares = vec![0.0; classes];
    for (ballot, weight) in ballots.iter().zip(relative_weights(ballots, sigma)) {
        if let Some(share) = shares.get_mut(ballot.class as usize) {
            *share += weight;
        }
    }
    let sum: f64 = shares.iter().sum();
    let uniform = 1.0 / classes.max(1) as f64;
    shares.iter().map(|share| if sum > 0.0 { share / sum } else { uniform }).collect()
}

/// The sum of the weights themselves.
pub(crate) fn kernel_mass(ballots: &[Ballot], sigma: f64) -> f64 {
    ballots.iter().map(|ballot| log_weight(ballot.distance, sigma).exp()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ballot(class: u16, distance: f64) -> Ballot {
        Ballot { class, distance, orientation: None }
    }

    #[test]
    fn equation_3_by_hand() {
        // sigma = 1: weights exp(-0.5), exp(-2), exp(-0.5).
        let ballots = [ballot(0, 1.0), ballot(0, 2.0), ballot(1, 1.0)];
        let (near, far) = ((-0.5f64).exp(), (-2.0f64).exp());
        let expected = (near + far) / (2.0 * near + far);
        let shares = probabilities(&ballots, 2, 1.0);
        assert!((shares[0] - expected).abs() < 1e-12, "{shares:?}");
        assert!((kernel_mass(&ballots, 1.0) - (2.0 * near + far)).abs() < 1e-12);
    }

    #[test]
    fn a_query_far_from_everything_still_has_probabilities() {
        let ballots = [ballot(0, 1e6), ballot(1, 1e6 + 1.0)];
        let shares = probabilities(&ballots, 3, 1.0);
        assert_eq!(shares, [1.0, 0.0, 0.0]);
        assert_eq!(kernel_mass(&ballots, 1.0), 0.0);
    }

    #[test]
    fn equal_descriptors_make_no_nan() {
        let shares = probabilities(&[ballot(1, 0.0), ballot(0, 0.5)], 2, 0.0);
        assert_eq!(shares, [0.0, 1.0]);
        assert_eq!(probabilities(&[], 2, 1.0), [0.5, 0.5]);
    }
}
