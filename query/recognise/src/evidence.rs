//! What the picture and its neighbours say about how far an answer can be relied on, beside the
//! neighbours' classes.

use grasp_index::Index;

use super::{Hypothesis, Prepared, Side};
use crate::scene::Scene;
use crate::segment::{Mask, Quality};

/// Evidence about one answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Of the mask by its colours, where the hand was found in a camera picture.
    pub quality: Option<Quality>,
    /// The share of the picture that the mask fills, 0..=1.
    pub share: f64,
    /// The distance of the nearest neighbour as a share of the farthest that known hands lie at;
    /// `None` where the index does not know it.
    pub nearest: Option<f64>,
    /// How far the neighbours disagree about the orientation, in degrees.
    pub spread_deg: f64,
    /// How much unlikelier the other hand is: 0 as likely, 1 as if its neighbours lay twice as far.
    /// `None` where it was not tried.
    pub other_hand: Option<f64>,
    /// What the scene network makes of the picture, where it has found the hand.
    pub scene: Option<SceneEvidence>,
}

/// What the scene network says about how far an answer can be relied on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneEvidence {
    /// How surely it knows the hand from the other one: the logarithm of the odds, 0 or more.
    pub side: f64,
    /// The share of what it or the mask takes for hand and forearm that both do, 0..=1.
    pub agrees: f64,
    /// How probable it finds the likeliest of its grasps, 0..=1.
    pub sure: f64,
}

impl SceneEvidence {
    fn of(scene: &Scene, skin: &Mask, side: Side) -> Self {
        let grasps = scene.prediction.probabilities(side);
        let (_no_grasp, grasps) = grasps.split_last().expect("the last is no grasp");
        let sure = grasps.iter().copied().fold(0.0, f64::max);
        Self { side: scene.prediction.right_odds.abs(), agrees: scene.found.agreement(skin), sure }
    }
}

/// No outline is shorter than a disc's, but for the pixels that it is drawn with.
const MIN_RAGGEDNESS: f64 = 0.5;
/// Fingers make no outline more ragged than that: nine of ten hands on plain ground have less.
/// Beyond it a mask is no more a hand.
const MAX_RAGGEDNESS: f64 = 4.0;
/// Odds beyond this, as a logarithm, say no more.
const MOST_ODDS: f64 = 4.0;
/// A measure is no larger than this, so that nothing is infinite.
const MOST: f64 = 10.0;

impl Evidence {
    /// The names of [`Self::measures`].
    pub const NAMES: [&str; 10] = [
        "skin_around",
        "on_border",
        "raggedness",
        "thickness",
        "nearest",
        "spread",
        "other_hand",
        "scene_side",
        "scene_agrees",
        "scene_sure",
    ];

    pub(super) fn of(index: &Index, prepared: &Prepared, best: &Hypothesis) -> Self {
        let nearest = best.neighbours.first().map_or(f64::INFINITY, |nearest| f64::from(nearest.distance));
        let mask = &prepared.mask;
        Self {
            quality: prepared.quality,
            share: mask.area() as f64 / mask.pixels().len().max(1) as f64,
            nearest: index.catalogue().calibration.farthest.map(|farthest| nearest / farthest),
            spread_deg: best.vote.orientation.spread_deg,
            other_hand: best.rival,
            scene: prepared
                .scene
                .as_ref()
                .map(|scene| SceneEvidence::of(scene, prepared.skin.as_ref().unwrap_or(mask), best.side)),
        }
    }

    /// The measures as a model takes them: shares and the spread on scales on which equal steps
    /// mean about the same.
    pub fn measures(&self) -> [Option<f64>; Self::NAMES.len()] {
        let scene = self.scene.as_ref();
        let quality = self.quality.as_ref();
        [
            quality.map(|quality| quality.skin_around.sqrt()),
            quality.map(|quality| quality.on_border.sqrt()),
            quality.map(|quality| libm::log(quality.raggedness.clamp(MIN_RAGGEDNESS, MAX_RAGGEDNESS))),
            quality.map(|quality| quality.thickness),
            self.nearest,
            // Neighbours that agree to 5 degrees and to none do so alike.
            Some(libm::log(self.spread_deg + 5.0)),
            self.other_hand.map(|farther| farther.max(0.0).sqrt()),
            scene.map(|scene| scene.side.min(MOST_ODDS)),
            scene.map(|scene| scene.agrees),
            scene.map(|scene| scene.sure),
        ]
        .map(|measure| measure.map(|measure| measure.clamp(-MOST, MOST)))
    }
}
