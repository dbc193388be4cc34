//! How far an answer about a camera picture is to be trusted.
//!
//! An index is calibrated on hands that were segmented rightly. A mask that was found in a camera
//! picture may be half a table, and what its neighbours agree on is then worth nothing. With a
//! probability t, the trust, the picture is taken to be one that the index's calibration holds for,
//! and else to show any of the C classes:
//!
//! ```text
//! P(c | picture) = t P(c | neighbours) + (1 - t) / C
//! ```
//!
//! t is a logistic function of [`Evidence`], fitted by `grasp-query experiment trust` to pictures
//! of hands before backgrounds that are hard to distinguish from skin (`data/trust*.toml`, which
//! name the command), but at least the model's floor: of photographs, which it was not fitted to,
//! it trusts those that are named rightly hardly more than the others (docs/trials.md). A mask
//! that was given is trusted, unless it is all of the picture.

use grasp_index::{DescriptorKind, DescriptorParams};
use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::Evidence;
use crate::segment::Finder;

/// A mask that fills more of its picture is no hand's outline: the picture was not segmented.
pub(super) const MOST_FILLED: f64 = 0.95;

/// A model of trust.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trust {
    /// The trust below which the hand is unknown.
    pub least: f64,
    /// The least t that probabilities are tempered by, 0..=1.
    pub floor: f64,
    /// For answers that both hands were tried for.
    pub hand_tried: Logistic,
    /// For answers whose hand was given.
    pub hand_given: Logistic,
}

/// A logistic function of [`Evidence`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Logistic {
    /// The logit of the trust where every measure is at its mean.
    pub bias: f64,
    /// What each measure of [`Evidence::NAMES`] adds.
    pub measures: BTreeMap<String, Term>,
}

/// One measure's part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// The measure's mean over the pictures that the model was fitted to.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Added to the logit for each standard deviation above the mean.
    pub weight: f64,
}

static OF_GRADIENTS: LazyLock<Trust> =
    LazyLock::new(|| toml::from_str(include_str!("../data/trust.toml")).expect("a test reads the same file"));
static OF_LEARNED: LazyLock<Trust> = LazyLock::new(|| {
    toml::from_str(include_str!("../data/trust-learned.toml")).expect("a test reads the same file")
});

static OF_SCENES: LazyLock<Trust> = LazyLock::new(|| {
    toml::from_str(include_str!("../data/trust-scene.toml")).expect("a test reads the same file")
});

impl Trust {
    /// The model that the program holds for a descriptor, and for what has found the hand:
    /// distances to neighbours, and how far the other hand's lie, mean something else for a learned
    /// one, and where the scene network looks, that says more than they do.
    pub fn of_descriptor(descriptor: &DescriptorParams, by: &Finder) -> &'static Self {
        match (by, descriptor.kind) {
            (Finder::Skin, DescriptorKind::Learned { .. }) => &OF_LEARNED,
            (Finder::Skin, _) => &OF_GRADIENTS,
            (_, _) => &OF_SCENES,
        }
    }

    /// The trust in an answer, 0..=1; `None` where the mask was given and is one.
    pub fn trust(&self, evidence: &Evidence) -> Option<f64> {
        if evidence.share > MOST_FILLED {
            return Some(0.0);
        }
        evidence.quality.as_ref()?;
        let model = if evidence.other_hand.is_some() { &self.hand_tried } else { &self.hand_given };
        Some(model.value(evidence))
    }

    /// What probabilities are tempered by where an answer is trusted so much.
    pub fn tempering(&self, trust: f64) -> f64 {
        trust.max(self.floor)
    }
}

impl Logistic {
    /// Its value, 0..=1. A measure that is not known counts as its mean.
    pub fn value(&self, evidence: &Evidence) -> f64 {
        let terms = Evidence::NAMES.iter().zip(evidence.measures()).filter_map(|(name, measure)| {
            let term = self.measures.get(*name)?;
            Some(term.weight * (measure? - term.mean) / term.deviation)
        });
        logistic(self.bias + terms.sum::<f64>())
    }
}

/// What a probability becomes by `trust`, among `classes` classes.
pub fn temper(probability: f64, trust: f64, classes: usize) -> f64 {
    trust * probability + (1.0 - trust) / classes.max(1) as f64
}

/// 1 / (1 + e^-logit).
pub fn logistic(logit: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-logit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::Quality;

    fn evidence(quality: Quality) -> Evidence {
        Evidence {
            quality: Some(quality),
            share: 0.1,
            nearest: Some(0.5),
            spread_deg: 12.0,
            other_hand: None,
            scene: None,
        }
    }

    const HAND: Quality = Quality { on_border: 0.0, skin_around: 0.02, raggedness: 2.5, thickness: 0.65 };

    #[test]
    fn the_built_in_model_knows_every_measure_and_no_other() {
        let mut names = Evidence::NAMES.to_vec();
        names.sort_unstable();
        let trusts = [&*OF_GRADIENTS, &*OF_LEARNED, &*OF_SCENES];
        for model in trusts.iter().flat_map(|trust| [&trust.hand_tried, &trust.hand_given]) {
            assert!(model.measures.keys().eq(&names), "{model:?}");
            assert!(model.measures.values().all(|term| term.deviation > 0.0));
        }
    }

    #[test]
    fn a_mask_that_runs_along_the_border_before_skin_is_trusted_less() {
        let model = &*OF_GRADIENTS;
        let hand = model.trust(&evidence(HAND)).unwrap();
        assert!(hand > 0.5, "{hand}");
        let board = Quality { on_border: 0.3, skin_around: 0.4, ..HAND };
        assert!(model.trust(&evidence(board)).unwrap() < 0.1);
        let given = Evidence { quality: None, ..evidence(HAND) };
        assert_eq!(model.trust(&given), None);
        assert_eq!(model.trust(&Evidence { share: 1.0, ..given }), Some(0.0));
    }

    #[test]
    fn tempered_probabilities_sum_to_1_and_keep_their_order() {
        let tempered = [0.7, 0.2, 0.1].map(|probability| temper(probability, 0.25, 3));
        assert!((tempered.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((tempered[0] - 0.425).abs() < 1e-12 && tempered[1] > tempered[2]);
        assert_eq!(temper(0.9, 1.0, 6), 0.9);
    }

    #[test]
    fn answers_are_tempered_by_the_floor_at_least() {
        let model = Trust { floor: 0.6, ..OF_GRADIENTS.clone() };
        assert_eq!([0.0, 0.6, 0.9].map(|trust| model.tempering(trust)), [0.6, 0.6, 0.9]);
    }
}
