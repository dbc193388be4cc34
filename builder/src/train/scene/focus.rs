//! What a network of scenes is for.

use grasp_renders::random::unit;
use grasp_renders::{Framing, Layers};
use grasp_train::Factors;
use rand_chacha::ChaCha8Rng;

use super::design::Design;
use crate::train::{Kind, StageShares};

/// What it is shown, and what it shall learn best.
#[derive(Clone, Copy, Debug)]
pub(super) struct Focus {
    /// The network's layers.
    pub(super) design: Design,
    /// How often the hand is yet to be found in a larger picture.
    far: f64,
    /// How often there is no hand at all.
    pub(super) nothing: f64,
    /// How often a scene's hand is cut out of its pictures.
    pub(super) cut_out: f64,
    /// The square around a hand that need not be found.
    near: fn(&Layers, &mut ChaCha8Rng) -> Framing,
    /// How often each stage is drawn.
    pub(super) stages: StageShares,
    /// The weight of each loss.
    pub(super) factors: Factors,
}

impl Focus {
    pub(super) fn of(kind: Kind) -> Self {
        // The masks of a network that names are not used, and its rotation only joins the vote's.
        let naming = Self {
            design: Design::Naming,
            far: 0.02,
            nothing: 0.02,
            cut_out: 0.35,
            near: Framing::found,
            stages: StageShares { reach: 0.13, close: 0.22 },
            factors: Factors { rotation: 0.4, masks: 1.0, joints: 2.0, ..Factors::default() },
        };
        match kind {
            Kind::Naming => naming,
            Kind::Thing => Self { cut_out: 0.0, near: Framing::thing, ..naming },
            // Only the masks matter here; the other outputs hardly count.
            Kind::Mask => Self {
                design: Design::Cutting,
                far: 0.1,
                nothing: 0.02,
                cut_out: 0.0,
                near: Framing::near,
                stages: StageShares::default(),
                factors: Factors { stage: 0.1, rotation: 0.3, masks: 15.0, joints: 1.0 },
            },
            Kind::Scene | Kind::Hand => Self {
                design: Design::Naming,
                far: 0.2,
                nothing: 0.04,
                cut_out: 0.0,
                near: Framing::near,
                stages: StageShares::default(),
                factors: Factors::default(),
            },
        }
    }

    /// Which square of a view is shown, and whether the hand is yet to be found in it.
    pub(super) fn framing(&self, layers: &Layers, rng: &mut ChaCha8Rng) -> (Framing, bool) {
        let is_far = unit(rng) < self.far;
        (if is_far { Framing::far(layers, rng) } else { (self.near)(layers, rng) }, is_far)
    }

    /// The square around a hand that need not be found.
    pub(super) fn near(&self, layers: &Layers, rng: &mut ChaCha8Rng) -> Framing {
        (self.near)(layers, rng)
    }
}
