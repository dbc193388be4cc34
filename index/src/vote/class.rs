//! Equation 3: every neighbour votes for its class with the weight `exp(-d^2 / (2 sigma^2))`.

/// The smallest sigma that is divided by: an index of equal descriptors has sigma 0. Far below that
/// of any others, and the square of a distance by it is finite.
const MIN_SIGMA: f64 = 1e-30;

/// The logarithm of a neighbour's weight.
fn log_weight(distance: f64, sigma: f64) -> f64 {
    let scaled = distance / sigma.max(MIN_SIGMA);
    -0.5 * scaled * scaled
}

/// The weights at these distances, divided by the greatest: far from everything all of them would
/// round to 0, and their ratios, which is what counts, with them.
pub(super) fn relative_weights(distances: impl Iterator<Item = f64>, sigma: f64) -> Vec<f64> {
    let logs: Vec<f64> = distances.map(|distance| log_weight(distance, sigma)).collect();
    let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    logs.iter().map(|log| if greatest.is_finite() { libm::exp(log - greatest) } else { 1.0 }).collect()
}

/// Each class's share of the weights of voters, given as class and distance. Without voters every
/// class has the same.
pub(crate) fn shares(
    voters: impl Iterator<Item = (u16, f64)> + Clone,
    classes: usize,
    sigma: f64,
) -> Vec<f64> {
    let mut shares = vec![0.0; classes];
    for ((class, _), weight) in
        voters.clone().zip(relative_weights(voters.map(|(_, distance)| distance), sigma))
    {
        if let Some(share) = shares.get_mut(usize::from(class)) {
            *share += weight;
        }
    }
    let sum: f64 = shares.iter().sum();
    let uniform = 1.0 / classes.max(1) as f64;
    shares.iter().map(|share| if sum > 0.0 { share / sum } else { uniform }).collect()
}

/// The sum of the weights themselves.
pub(crate) fn kernel_mass(distances: impl Iterator<Item = f64>, sigma: f64) -> f64 {
    distances.map(|distance| libm::exp(log_weight(distance, sigma))).sum()
}

#[cfg(test)]
mod tests {

    fn shares<const N: usize>(voters: [(u16, f64); N], classes: usize, sigma: f64) -> Vec<f64> {
        super::shares(voters.into_iter(), classes, sigma)
    }

    fn kernel_mass<const N: usize>(voters: [(u16, f64); N], sigma: f64) -> f64 {
        super::kernel_mass(voters.into_iter().map(|(_, distance)| distance), sigma)
    }

    #[test]
    fn equation_3_by_hand() {
        // sigma = 1: weights exp(-0.5), exp(-2), exp(-0.5).
        let ballots = [(0, 1.0), (0, 2.0), (1, 1.0)];
        let (near, far) = (libm::exp(-0.5), libm::exp(-2.0));
        let expected = (near + far) / (2.0 * near + far);
        let found = shares(ballots, 2, 1.0);
        assert!((found[0] - expected).abs() < 1e-12, "{found:?}");
        assert!((kernel_mass(ballots, 1.0) - (2.0 * near + far)).abs() < 1e-12);
    }

    #[test]
    fn a_query_far_from_everything_still_has_shares() {
        let ballots = [(0, 1e6), (1, 1e6 + 1.0)];
        let found = shares(ballots, 3, 1.0);
        assert_eq!(found, [1.0, 0.0, 0.0]);
        assert_eq!(kernel_mass(ballots, 1.0), 0.0);
    }

    #[test]
    fn the_unit_of_distances_does_not_matter() {
        // exp(-0.5) and exp(-2), whatever all is multiplied by.
        let expected = shares([(0, 1.0), (1, 2.0)], 2, 1.0);
        for unit in [1e-20, 1e-12, 1e12] {
            let found = shares([(0, unit), (1, 2.0 * unit)], 2, unit);
            assert!((found[0] - expected[0]).abs() < 1e-12, "{unit}: {found:?}");
        }
    }

    #[test]
    fn equal_descriptors_make_no_nan() {
        let found = shares([(1, 0.0), (0, 0.5)], 2, 0.0);
        assert_eq!(found, [0.0, 1.0]);
        assert_eq!(shares([], 2, 1.0), [0.5, 0.5]);
    }
}
