//! How neighbours are weighed, and what that is worth.

use grasp_index::Calibration;
use serde::Serialize;

/// How neighbours are weighed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VoteInfo {
    /// How many neighbours vote.
    pub k: u32,
    /// The factor on sigma that makes the kernel's width.
    pub sigma_scale: f64,
    /// Added to each class's share of the weights.
    pub floor: f64,
    /// The power that turns shares into probabilities.
    pub power: f64,
    /// The distance of the nearest neighbour, beyond which there is no answer.
    pub farthest: Option<f64>,
    /// The probability below which there is no answer.
    pub least_probability: f64,
    /// How well that was measured to do; null where it was not.
    pub measured: Option<MeasuredVote>,
}

/// How well the vote does on queries that it was not fitted to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredVote {
    /// How many queries.
    pub queries: u32,
    /// How far they were moved, in units of sigma: least and most.
    pub noise: [f64; 2],
    /// The share that is right.
    pub top1: Option<f64>,
    /// The mean logarithm of the labelled class's probability.
    pub log_likelihood: f64,
    /// The expected calibration error.
    pub ece: Option<f64>,
    /// Bins of probability that have answers.
    pub reliability: Vec<ReliabilityInfo>,
}

/// The answers of a bin of probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReliabilityInfo {
    /// How many there are.
    pub n: u32,
    /// Their mean probability.
    pub probability: Option<f64>,
    /// The share of them that is right.
    pub right: Option<f64>,
}

impl From<&Calibration> for VoteInfo {
    fn from(calibration: &Calibration) -> Self {
        let &Calibration { k, sigma_scale, floor, power, farthest, least_probability, ref measured } =
            calibration;
        let measured = measured.as_ref().map(|measured| {
            let reliability = &measured.reliability;
            let bins = reliability.bins.iter().filter(|bin| bin.n > 0);
            let bins =
                bins.map(|bin| ReliabilityInfo { n: bin.n, probability: bin.stated(), right: bin.found() });
            MeasuredVote {
                queries: reliability.n(),
                noise: measured.noise,
                top1: reliability.accuracy(),
                log_likelihood: measured.log_likelihood,
                ece: reliability.expected_error(),
                reliability: bins.collect(),
            }
        });
        Self { k, sigma_scale, floor, power, farthest, least_probability, measured }
    }
}
