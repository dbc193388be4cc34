//! Fitting what an open hand is likelier to do than it looks: the logarithms under which the labels
//! are likeliest.

use nalgebra::DVector;

/// Steps uphill, and how long one is: the likelihood no longer changes in its fifth digit.
const STEPS: usize = 800;
const STEP: f64 = 0.5;
/// What a logarithm costs: half its square times this, against the sum of the logarithms of the
/// labels' probabilities.
const RIDGE: f64 = 6.0;

/// What is fitted to: one picture.
#[derive(Clone, Debug)]
pub(super) struct Example {
    /// The logarithm of each class's probability as the picture looks.
    pub(super) logs: DVector<f64>,
    /// The labelled class.
    pub(super) labelled: usize,
    /// The probability that the hand holds nothing yet, 0..=1.
    pub(super) open: f64,
}

impl Example {
    /// The probability of each class where an open hand has these log-odds.
    pub(super) fn weighed(&self, log_odds: &DVector<f64>) -> DVector<f64> {
        let logs = &self.logs + log_odds * self.open;
        let most = logs.max();
        let values = logs.map(|log| libm::exp(log - most));
        let total = values.sum();
        values / total
    }
}

/// The log-odds of the `classes` classes of the examples. Where there is nothing
/// to learn from, all are 0.
pub(super) fn fit(examples: &[&Example], classes: usize) -> DVector<f64> {
    let mut log_odds = DVector::zeros(classes);
    for _ in 0..STEPS {
        let mut slope = DVector::zeros(classes);
        for example in examples {
            slope -= example.weighed(&log_odds) * example.open;
            slope[example.labelled] += example.open;
        }
        slope -= &log_odds * RIDGE;
        log_odds += slope * (STEP / (examples.len() as f64 + RIDGE));
    }
    log_odds
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands that look like one class as like the other; of the open ones nine in ten are of the
    /// second, of the others half.
    fn examples() -> Vec<Example> {
        let example = |at: usize| {
            let is_open = at.is_multiple_of(2);
            let labelled =
                if is_open { usize::from(!at.is_multiple_of(20)) } else { usize::from(at % 4 == 1) };
            Example { logs: DVector::zeros(2), labelled, open: if is_open { 1.0 } else { 0.0 } }
        };
        (0..400).map(example).collect()
    }

    #[test]
    fn what_open_hands_do_more_often_is_likelier() {
        let examples = examples();
        let log_odds = fit(&examples.iter().collect::<Vec<_>>(), 2);
        assert!(log_odds.sum().abs() < 1e-9, "{log_odds}");
        let [open, closed] = [0, 1].map(|at: usize| examples[at].weighed(&log_odds)[1]);
        assert!((open - 0.9).abs() < 0.03 && closed == 0.5, "{open} {closed}");
    }

    #[test]
    fn the_slope_vanishes_where_the_fit_ends() {
        let examples = examples();
        let examples: Vec<&Example> = examples.iter().collect();
        let worth = |log_odds: &DVector<f64>| {
            let logs = examples.iter().map(|e| libm::log(e.weighed(log_odds)[e.labelled]));
            logs.sum::<f64>() - 0.5 * RIDGE * log_odds.norm_squared()
        };
        let best = fit(&examples, 2);
        for moved in [[0.05, 0.0], [-0.05, 0.0], [0.0, 0.05], [0.0, -0.05]] {
            assert!(worth(&(&best + DVector::from_row_slice(&moved))) < worth(&best));
        }
    }

    #[test]
    fn nothing_is_learned_from_nothing() {
        assert_eq!(fit(&[], 3), DVector::zeros(3));
    }
}
