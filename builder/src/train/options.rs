//! What a training is asked for.

use std::fmt;

use grasp_network::{Architecture, Convolution};
use grasp_renders::PoseGroup;
use grasp_train::{ROTATION, STAGES};
use serde::{Deserialize, Serialize};

/// Samples of the shipped network.
pub const DEFAULT_SAMPLES: u64 = 2_200_000;
/// The seed of the shipped network.
pub const DEFAULT_SEED: u64 = 7;
/// Samples from one validation to the next, unless others are asked for.
pub const DEFAULT_VALIDATE_EVERY: u64 = 100_000;

/// The learning rate after the warm-up.
pub(super) const PEAK_RATE: f32 = 2e-3;
/// The share of a batch that is augmented hard, at first.
const HARD_AT_FIRST: f64 = 0.1;
/// How fast that share rises: by so much over all steps, were there no limit.
const HARDENING: f64 = 0.6;
/// The largest share of a batch that is augmented hard.
const HARD_AT_MOST: f64 = 0.5;

/// What the trained network and its curve follow from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// Pictures that the network is shown in all, in full batches.
    pub samples: u64,
    /// What all randomness comes from.
    pub seed: u64,
    /// Whether a fifth of the recorded poses is not trained on.
    pub hold_out_poses: bool,
    /// Samples from one validation to the next.
    pub validate_every: u64,
}

/// As they are written on the command line.
impl fmt::Display for Options {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, seed, hold_out_poses, validate_every } = self;
        write!(formatter, "--samples {samples} --seed {seed} --validate-every {validate_every}")?;
        if *hold_out_poses { write!(formatter, " --hold-out-poses") } else { Ok(()) }
    }
}

impl Options {
    /// The recorded poses that are trained on.
    pub(super) fn poses(&self) -> PoseGroup {
        if self.hold_out_poses { PoseGroup::Kept } else { PoseGroup::All }
    }

    /// The seed of the random weights. Those of scenes, picks and variations are others.
    pub(super) fn seed_of_weights(&self) -> u64 {
        self.seed ^ 6
    }

    /// The seed by which batches are picked from the window.
    pub(super) fn seed_of_picks(&self) -> u64 {
        self.seed ^ 2
    }

    /// The seed by which pictures are varied.
    pub(super) fn seed_of_variations(&self) -> u64 {
        self.seed ^ 1
    }
}

/// How many of a batch's samples are augmented hard at a step.
pub(super) fn hard_samples(batch: usize, step: u64, steps: u64) -> usize {
    let share = (HARD_AT_FIRST + HARDENING * step as f64 / steps as f64).min(HARD_AT_MOST);
    (share * batch as f64).ceil() as usize
}

/// The network that is trained to distinguish so many classes, and hands that are mirrored.
pub(super) fn architecture(classes: usize) -> Architecture {
    let convolution = |kernel, stride, outputs| Convolution { kernel, stride, outputs };
    Architecture {
        side: grasp_index::PLANES_SIDE as u32,
        planes: 2,
        convolutions: vec![
            convolution(5, 2, 16),
            convolution(3, 2, 32),
            convolution(3, 1, 48),
            convolution(3, 2, 96),
            convolution(3, 1, 96),
        ],
        embedding: 128,
        heads: (classes + 1 + STAGES + ROTATION) as u32,
    }
}
