//! Equation 5: sigma, the width of the kernel of Equations 3 and 4.
//!
//! Its words, "the mean intra-class, inter-point distance", and its formula do not agree: the
//! formula divides the sum over ordered pairs by `sqrt(2) M N` where a mean needs `M N (N - 1)`, so
//! that it comes out about `(N - 1) / sqrt(2)` times too large and every weight of Equation 3 is 1.
//! The words are what is used; the formula is kept beside it.

use crate::search::distance;
use rayon::prelude::*;

/// At most so many descriptors of a class are paired; of more, evenly spaced ones are.
const MOST_OF_A_CLASS: usize = 3_000;

/// Both readings of Equation 5, in units of descriptor distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigma {
    /// The mean distance between two descriptors of one class, averaged over the classes: the
    /// words.
    pub mean_distance: f64,
    /// The formula as printed, `sqrt(2) M N` below: for repeating the paper's figures.
    pub literal: f64,
}

/// The mean distance between two different rows, all of one length: 0 for fewer than two.
pub fn mean_distance(rows: &[&[f32]]) -> f64 {
    let n = rows.len();
    if n < 2 {
        return 0.0;
    }
    // One sum a row, added in order of the rows: the same bits at any number of threads.
    let sums: Vec<f64> = (0..n)
        .into_par_iter()
        .map(|i| rows[i + 1..].iter().map(|row| f64::from(distance::squared(rows[i], row).sqrt())).sum())
        .collect();
    let pairs = n as f64 * (n - 1) as f64 / 2.0;
    sums.iter().sum::<f64>() / pairs
}

/// Measures sigma over `descriptors` (`dim` values a row), `labels` being the class of each row.
/// Classes with fewer than two rows do not count. Without labels all rows are of one class.
pub(crate) fn measure(descriptors: &[f32], dim: usize, labels: &[u16], classes: usize) -> Sigma {
    let rows = || descriptors.chunks_exact(dim.max(1));
    let mut counts = vec![0usize; classes];
    for &label in labels {
        if let Some(count) = counts.get_mut(usize::from(label)) {
            *count += 1;
        }
    }
    if labels.is_empty() {
        counts = vec![rows().len()];
    }
    let (mut mean, mut literal, mut counted) = (0.0, 0.0, 0.0);
    for (class, &count) in counts.iter().enumerate().filter(|(_, count)| **count >= 2) {
        let paired = count.min(MOST_OF_A_CLASS);
        let mut of_class =
            rows().enumerate().filter(|&(id, _)| labels.get(id).is_none_or(|&label| label as usize == class));
        // Evenly spaced: of the rows not yet passed, the one so many further on.
        let mut passed = 0;
        let spaced = (0..paired).filter_map(|at| {
            let wanted = at * count / paired;
            let skip = wanted - passed;
            passed = wanted + 1;
            of_class.nth(skip).map(|(_, row)| row)
        });
        // Copied, for each is read once for every other: where they lie on a disk, few of their
        // pages may stay in memory.
        let spaced: Vec<f32> = spaced.flatten().copied().collect();
        let distance = mean_distance(&spaced.chunks_exact(dim.max(1)).collect::<Vec<_>>());
        mean += distance;
        literal += distance * (count - 1) as f64 / std::f64::consts::SQRT_2;
        counted += 1.0;
    }
    if counted == 0.0 {
        return Sigma { mean_distance: 0.0, literal: 0.0 };
    }
    Sigma { mean_distance: mean / counted, literal: literal / counted }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_readings_by_hand() {
        // Class 0: the points 0, 3 and 9 of a line, at distances 3, 6 and 9. Class 1: 0 and 2, at
        // distance 2.
        let descriptors = [0.0, 3.0, 9.0, 0.0, 2.0];
        let sigma = measure(&descriptors, 1, &[0, 0, 0, 1, 1], 2);
        assert!((sigma.mean_distance - (6.0 + 2.0) / 2.0).abs() < 1e-9, "{sigma:?}");
        // Ordered pairs sum to 36 and 4; divided by sqrt(2) N they are 12 / sqrt(2) and 2 /
        // sqrt(2), then the mean of M = 2.
        assert!((sigma.literal - 7.0 / std::f64::consts::SQRT_2).abs() < 1e-9, "{sigma:?}");
    }

    #[test]
    fn classes_without_pairs_do_not_count() {
        assert_eq!(measure(&[1.0, 5.0], 1, &[0, 1], 2).mean_distance, 0.0);
        assert_eq!(measure(&[1.0, 5.0, 7.0], 1, &[0, 1, 1], 2).mean_distance, 2.0);
    }

    #[test]
    fn of_many_rows_evenly_spaced_ones_are_paired() {
        // Twice as many as are paired: every second, so that only distances of 2 times an integer
        // are measured.
        let (rows, paired): (Vec<f32>, Vec<f32>) =
            (0..2 * MOST_OF_A_CLASS).map(|at| (at as f32, (at / 2 * 2) as f32)).unzip();
        let every_second: Vec<&[f32]> = paired.chunks(2).map(|pair| &pair[..1]).collect();
        let labels = vec![0; rows.len()];
        assert_eq!(measure(&rows, 1, &labels, 1).mean_distance, mean_distance(&every_second));
        assert_eq!(measure(&rows, 1, &[], 0).mean_distance, mean_distance(&every_second));
    }
}
