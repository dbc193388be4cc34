//! When neighbours make an answer, and when the hand is unknown.

use grasp_index::{Calibration, Index, Vote, VoteOptions};

use super::Hypothesis;
use super::options::Accept;
use super::trust::temper;

/// From which probability of none of the grasps on there is no answer. At 0.6 this would reject 18
/// of 999 hands of another origin that do make one, 13 of them named correctly; at 0.8 it rejects 6
/// (docs/accuracy.md).
const LIKELY_NONE: f64 = 0.8;

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// The neighbours make none.
    #[error(transparent)]
    Neighbours(#[from] grasp_index::Doubt),
    /// The hand holds nothing, or something in another way.
    #[error(
        "the hand is in none of the grasps: {:.0} % likely by all that is seen (`accept always` names one all the same)",
        100.0 * probability
    )]
    NoneOfTheGrasps {
        /// How likely that is, 0..=1.
        probability: f64,
    },
    /// What was found in a camera picture cannot be relied on.
    #[error(
        "pictures like this one are rarely recognised correctly: trust {trust:.4}, at least {least:.3} is needed (a mask can be given)"
    )]
    Unreliable {
        /// The trust, 0..=1.
        trust: f64,
        /// The least that makes an answer.
        least: f64,
    },
}

impl Doubt {
    /// Whether the hand is known and merely no class stands out.
    pub(super) fn is_unsure(self) -> bool {
        matches!(self, Self::Neighbours(grasp_index::Doubt::TooUnsure { .. }))
    }
}

/// How far an answer about a camera picture is trusted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trusted {
    pub(super) trust: f64,
    /// The trust below which there is no answer.
    pub(super) least: f64,
    /// What its probabilities were tempered by.
    pub(super) tempering: f64,
}

impl Accept {
    /// What speaks against the hypothesis.
    pub(super) fn doubt(
        self,
        index: &Index,
        best: &Hypothesis,
        trusted: Option<Trusted>,
        vote: &VoteOptions,
    ) -> Option<Doubt> {
        let nearest = best.neighbours.first().map_or(f64::INFINITY, |nearest| f64::from(nearest.distance));
        let tempering = trusted.map(|trusted| trusted.tempering);
        let far = self.limits(index, vote, tempering).doubt(nearest, first_probability(&best.vote));
        let unreliable = || {
            let Trusted { trust, least, .. } = trusted?;
            (self == Self::Calibrated && trust < least).then_some(Doubt::Unreliable { trust, least })
        };
        far.map(Doubt::from).filter(|doubt| !doubt.is_unsure()).or_else(unreliable).or(far.map(Doubt::from))
    }

    /// Whether the hand is rather in none of the grasps, which is so likely.
    pub(super) fn none_of_the_grasps(self, probability: f64) -> Option<Doubt> {
        let is_none = self == Self::Calibrated && probability > LIKELY_NONE;
        is_none.then_some(Doubt::NoneOfTheGrasps { probability })
    }

    /// What speaks against the classes' probabilities, wherever the neighbours lie.
    pub(super) fn unsure(
        self,
        index: &Index,
        found: &Vote,
        tempering: Option<f64>,
        vote: &VoteOptions,
    ) -> Option<Doubt> {
        let limits = Calibration { farthest: None, ..self.limits(index, vote, tempering) };
        limits.doubt(0.0, first_probability(found)).map(Doubt::from)
    }

    fn limits(self, index: &Index, vote: &VoteOptions, tempering: Option<f64>) -> Calibration {
        let calibration = index.catalogue().calibration;
        // The limit was found for what neighbours say, and is tempered as that is.
        let tempered = |by| temper(calibration.least_probability, by, index.catalogue().classes.len());
        let least_probability = match calibration.least_probability > 0.0 {
            true => tempering.map_or(calibration.least_probability, tempered),
            false => 0.0,
        };
        match self {
            Self::Always => Calibration::default(),
            // The weights' shares are not what the limit was found for.
            Self::Calibrated if vote.has_own_width() => Calibration { least_probability: 0.0, ..calibration },
            Self::Calibrated => Calibration { least_probability, ..calibration },
            Self::Within(farthest) => Calibration { farthest: Some(farthest), ..Calibration::default() },
        }
    }
}

fn first_probability(vote: &Vote) -> f64 {
    vote.classes.first().map_or(0.0, |class| class.probability)
}
