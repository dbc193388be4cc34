//! Whether probabilities come true.

use std::fmt::Write as _;

use grasp_index::{Reliability, ReliabilityBin};
use grasp_terminal::text::counted;
use serde::Serialize;

use super::{Guess, Outcome};

/// The least probability that a logarithm is taken of: without calibration a class may have none.
const LEAST: f64 = 1e-6;

/// How probabilities and right answers go together, over labelled pictures that have an answer.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    /// How many pictures there are.
    pub n: u32,
    /// The expected calibration error over ten bins: 0 where what is stated comes true.
    pub ece: Option<f64>,
    /// The mean logarithm of the labelled class's probability: 0 at best, -1.79 where all of six
    /// classes are as probable.
    pub log_likelihood: Option<f64>,
    /// Answers by the probability that they state; bins without answers are left out.
    pub reliability: Vec<BinReport>,
    /// What became of answers that state a high probability. Pictures of none of the classes count
    /// as wrong, whatever they were taken for; those that are unknown state nothing.
    pub stated_above: Vec<StatedAbove>,
}

/// The answers that state more than a probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatedAbove {
    /// The probability.
    pub probability: f64,
    /// How many answers state more.
    pub n: usize,
    /// How many of them are right.
    pub right: usize,
}

/// Probabilities that answers are counted above.
const ABOVE: [f64; 2] = [0.9, 0.8];

/// The answers whose probability lies in one bin.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BinReport {
    /// The least probability of the bin.
    pub from: f64,
    /// The least of the next.
    pub to: f64,
    /// How many answers there are.
    pub n: u32,
    /// The mean probability that they state.
    pub probability: f64,
    /// The share of them that is right.
    pub right: f64,
}

impl CalibrationReport {
    /// Over labelled pictures of the index's classes, and `all` pictures, those of none of them
    /// included.
    pub(super) fn new(outcomes: &[&Outcome], all: &[&Outcome]) -> Self {
        let answers: Vec<(&Guess, &Outcome)> =
            outcomes.iter().filter_map(|outcome| Some((outcome.guess()?, *outcome))).collect();
        let likelihoods = answers.iter().map(|(guess, outcome)| {
            let labelled = guess.classes.iter().find(|(name, _)| *name == outcome.label.grasp);
            labelled.map_or(LEAST, |(_, probability)| probability.max(LEAST)).ln()
        });
        let log_likelihood = super::errors::mean(likelihoods);
        // Whether or not it was enough for an answer.
        let is_right = |guess: &Guess, outcome: &Outcome| {
            guess.classes.first().is_some_and(|(name, _)| *name == outcome.label.grasp)
        };
        let stated = answers.iter().map(|(guess, outcome)| (guess.probability, is_right(guess, outcome)));
        let reliability = Reliability::from_answers(stated);
        let bins = reliability.bins.iter().zip(0u8..).filter_map(|(bin, at)| BinReport::new(bin, at));
        Self {
            n: reliability.n(),
            ece: reliability.expected_error(),
            log_likelihood,
            reliability: bins.collect(),
            stated_above: ABOVE.map(|probability| StatedAbove::new(probability, all)).into(),
        }
    }

    pub(super) fn write_text(&self, text: &mut String) -> std::fmt::Result {
        for StatedAbove { probability, n, right } in &self.stated_above {
            writeln!(text, "stated above {probability:.1}: {n}, of which {right} are right")?;
        }
        let (Some(ece), Some(log_likelihood)) = (self.ece, self.log_likelihood) else {
            return Ok(());
        };
        writeln!(
            text,
            "calibration error {ece:.3} over {}, log-likelihood {log_likelihood:.3}",
            counted(self.n, ["answer", "answers"])
        )?;
        for bin in &self.reliability {
            writeln!(
                text,
                "  stated {:.2}: right {:5.1} %  of {}",
                bin.probability,
                100.0 * bin.right,
                bin.n
            )?;
        }
        Ok(())
    }
}

impl StatedAbove {
    fn new(probability: f64, outcomes: &[&Outcome]) -> Self {
        let states_more = |outcome: &&&Outcome| {
            !outcome.is_unknown() && outcome.guess().is_some_and(|guess| guess.probability > probability)
        };
        let stated: Vec<_> = outcomes.iter().filter(states_more).collect();
        let right = stated.iter().filter(|outcome| outcome.is_right()).count();
        Self { probability, n: stated.len(), right }
    }
}

impl BinReport {
    fn new(bin: &ReliabilityBin, at: u8) -> Option<Self> {
        let (from, to) = (f64::from(at) / 10.0, f64::from(at + 1) / 10.0);
        Some(Self { from, to, n: bin.n, probability: bin.stated()?, right: bin.found()? })
    }
}
