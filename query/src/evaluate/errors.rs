//! Means and medians of errors.

use serde::Serialize;

/// Mean and median of some errors; null where there are none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// How many there are.
    pub n: usize,
    /// Their mean.
    pub mean: Option<f64>,
    /// Their median.
    pub median: Option<f64>,
}

pub(super) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0usize), |(sum, n), value| (sum + value, n + 1));
    (n > 0).then(|| sum / n as f64)
}

pub(super) fn errors(mut angles: Vec<f64>) -> Errors {
    angles.sort_by(f64::total_cmp);
    let middle = angles.len() / 2;
    let median = match angles.len() {
        0 => None,
        n if n % 2 == 1 => angles.get(middle).copied(),
        _ => angles.get(middle - 1..=middle).map(|two| two.iter().sum::<f64>() / 2.0),
    };
    Errors { n: angles.len(), mean: mean(angles.iter().copied()), median }
}
