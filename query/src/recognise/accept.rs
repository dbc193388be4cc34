//! When neighbours make an answer, and when the hand is unknown.

use grasp_index::{Calibration, Doubt, Index, Vote, VoteOptions};

use super::Hypothesis;

/// What is taken for an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Accept {
    /// Everything.
    Always,
    /// What lies within the limits that the index was calibrated with.
    #[default]
    Calibrated,
    /// What has its nearest neighbour within this distance.
    Within(f64),
}

impl Accept {
    /// What speaks against the hypothesis.
    pub(super) fn doubt(self, index: &Index, best: &Hypothesis, vote: &VoteOptions) -> Option<Doubt> {
        let nearest = best.neighbours.first().map_or(f64::INFINITY, |nearest| f64::from(nearest.distance));
        self.limits(index, vote).doubt(nearest, first_probability(&best.vote))
    }

    /// What speaks against the classes' probabilities, wherever the neighbours lie.
    pub(super) fn unsure(self, index: &Index, found: &Vote, vote: &VoteOptions) -> Option<Doubt> {
        let limits = Calibration { farthest: None, ..self.limits(index, vote) };
        limits.doubt(0.0, first_probability(found))
    }

    fn limits(self, index: &Index, vote: &VoteOptions) -> Calibration {
        let calibration = index.catalogue().calibration;
        match self {
            Self::Always => Calibration::default(),
            // The weights' shares are not what the limit was found for.
            Self::Calibrated if vote.has_own_width() => Calibration { least_probability: 0.0, ..calibration },
            Self::Calibrated => calibration,
            Self::Within(farthest) => Calibration { farthest: Some(farthest), ..Calibration::default() },
        }
    }
}

fn first_probability(vote: &Vote) -> f64 {
    vote.classes.first().map_or(0.0, |class| class.probability)
}
