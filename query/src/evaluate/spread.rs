//! Whether the spread of an orientation foretells its error.

use std::fmt::Write as _;

use serde::Serialize;

use super::Outcome;
use super::errors::{Errors, errors};

/// Where bins begin, in degrees.
const FROM: [f64; 5] = [0.0, 10.0, 20.0, 30.0, 45.0];

/// Errors by spread, over labelled pictures that have an answer and a labelled rotation.
#[derive(Clone, Debug, Serialize)]
pub struct SpreadReport {
    /// Spearman's correlation of spread and error, -1..=1: 1 where the order of the ones is that of
    /// the others. Null for fewer than three pictures.
    pub correlation: Option<f64>,
    /// The errors of pictures by their spread; bins without pictures are left out.
    pub bins: Vec<SpreadBin>,
}

/// The pictures whose spread lies in one bin.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SpreadBin {
    /// The least spread, in degrees.
    pub from_deg: f64,
    /// The least of the next; null for the last.
    pub to_deg: Option<f64>,
    /// Their errors in degrees.
    pub error_deg: Errors,
}

impl SpreadReport {
    pub(super) fn new(outcomes: &[&Outcome]) -> Self {
        let pairs: Vec<(f64, f64)> = outcomes
            .iter()
            .filter_map(|outcome| Some((outcome.guess()?.spread_deg, outcome.orientation_error_deg()?)))
            .collect();
        let bins = FROM.iter().enumerate().map(|(at, &from_deg)| {
            let to_deg = FROM.get(at + 1).copied();
            let within = |spread: f64| spread >= from_deg && to_deg.is_none_or(|to| spread < to);
            let own = pairs.iter().filter(|(spread, _)| within(*spread));
            SpreadBin { from_deg, to_deg, error_deg: errors(own.map(|(_, error)| *error).collect()) }
        });
        let bins = bins.filter(|bin| bin.error_deg.n > 0).collect();
        let (spreads, angles): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        Self { correlation: correlation(&ranks(&spreads), &ranks(&angles)), bins }
    }

    pub(super) fn write_text(&self, text: &mut String) -> std::fmt::Result {
        if let Some(correlation) = self.correlation {
            writeln!(text, "  by spread (rank correlation {correlation:.2})")?;
        }
        for bin in &self.bins {
            let to = bin.to_deg.map_or_else(|| "and more".to_owned(), |to| format!("to {to:.0}°"));
            let (median, mean) = (bin.error_deg.median.unwrap_or(0.0), bin.error_deg.mean.unwrap_or(0.0));
            writeln!(
                text,
                "    {:>3.0}° {to:<8}  mean {mean:.1}°, median {median:.1}° over {}",
                bin.from_deg, bin.error_deg.n
            )?;
        }
        Ok(())
    }
}

/// The place of each value in their order, from 0; equals share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |value: f64| values.iter().filter(|other| **other < value).count() as f64;
    let equal = |value: f64| values.iter().filter(|other| **other == value).count() as f64;
    values.iter().map(|&value| below(value) + (equal(value) - 1.0) / 2.0).collect()
}

/// Pearson's correlation; `None` where it has no meaning.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let n = a.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let product = |x: &[f64], mean_x: f64, y: &[f64], mean_y: f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum()
    };
    let spread = (product(a, mean_a, a, mean_a) * product(b, mean_b, b, mean_b)).sqrt();
    (a.len() > 2 && spread > 0.0).then(|| product(a, mean_a, b, mean_b) / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_and_their_correlation() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 9.0]), [1.5, 0.0, 1.5, 3.0]);
        let up = ranks(&[1.0, 10.0, 100.0, 1e6]);
        assert_eq!(correlation(&up, &ranks(&[2.0, 3.0, 4.0, 5.0])), Some(1.0));
        assert_eq!(correlation(&up, &ranks(&[5.0, 4.0, 3.0, 2.0])), Some(-1.0));
        assert_eq!(correlation(&up, &[1.0; 4]), None);
        assert_eq!(correlation(&[0.0, 1.0], &[0.0, 1.0]), None);
    }
}
