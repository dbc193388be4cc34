//! What a training is asked for.

use std::fmt;

use grasp_renders::PoseGroup;
use serde::{Deserialize, Serialize};

use super::left_out::LeftOut;

/// Samples from one validation to the next, unless others are asked for.
pub const DEFAULT_VALIDATE_EVERY: u64 = 100_000;

/// The learning rate after the warm-up unless another is asked for, of random weights and of a
/// trained network's.
const PEAK_RATE: f32 = 2e-3;
const PEAK_RATE_OF_TRAINED: f32 = 1e-3;
/// The share of a batch that is augmented hard, at first.
const HARD_AT_FIRST: f64 = 0.1;
/// How fast that share rises: by so much over all steps, were there no limit.
const HARDENING: f64 = 0.6;
/// The largest share of a batch that is augmented hard, and that of networks of scenes.
const HARD_AT_MOST: f64 = 0.5;
const HARD_AT_MOST_NAMED: f64 = 0.25;

/// Which network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The learned descriptor's, which sees a hand that was cut out and turned upright.
    #[default]
    Hand,
    /// The scene network, which sees a part of a camera picture: it finds hand, arm and object, and
    /// names the grasp by all that it sees.
    Scene,
    /// The naming network, of the same form, which names hands that have been found or cut out.
    Naming,
    /// The thing network, of the same form, which names a grasp by what is held, seen large.
    Thing,
    /// The mask network, which says finely what is hand, arm and object in the square around a hand
    /// that has been found.
    Mask,
}

impl Kind {
    /// Samples of the shipped network's last training.
    pub fn default_samples(self) -> u64 {
        match self {
            Self::Hand => 3_200_000,
            Self::Scene => 1_600_000,
            Self::Naming => 1_000_000,
            Self::Thing => 1_000_000,
            Self::Mask => 640_000,
        }
    }
}

/// How weights are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Optimiser {
    /// Matrices along their momentum made orthogonal, all else by Adam: from random weights, a
    /// network learns faster.
    #[default]
    Muon,
    /// All by Adam, as most of the shipped networks were trained.
    Adam,
}

impl From<Optimiser> for grasp_train::Optimiser {
    fn from(optimiser: Optimiser) -> Self {
        match optimiser {
            Optimiser::Muon => Self::Muon,
            Optimiser::Adam => Self::Adam,
        }
    }
}

/// What the trained network and its curve follow from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Which network is trained.
    pub kind: Kind,
    /// Pictures that the network is shown in all, in full batches.
    pub samples: u64,
    /// What all randomness comes from.
    pub seed: u64,
    /// Whether a fifth of the recorded poses is not trained on.
    pub hold_out_poses: bool,
    /// The share of the other recorded poses that is trained on, in percent.
    pub recorded_percent: u8,
    /// How many hand shapes are drawn; `None` of no end.
    pub hands: Option<u64>,
    /// Samples from one validation to the next.
    pub validate_every: u64,
    /// The fingerprint of the network whose weights it begins with; random ones without.
    pub start: Option<u64>,
    /// How weights are moved.
    pub optimiser: Optimiser,
    /// The learning rate after the warm-up, above 0; `None` takes the usual one.
    pub peak_rate: Option<f32>,
    /// How much of that network's weights the network that is written has, in percent; the rest is
    /// of the trained ones.
    pub keep_percent: u8,
    /// What is not random in its scenes.
    pub left_out: Vec<LeftOut>,
}

/// Nearly as they are written on the command line: a network that was begun with by its
/// fingerprint.
impl fmt::Display for Options {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, samples, seed, validate_every, start, optimiser, .. } = self;
        let Self { peak_rate, keep_percent, left_out, .. } = self;
        match kind {
            Kind::Hand => (),
            Kind::Scene => write!(formatter, "--kind scene ")?,
            Kind::Naming => write!(formatter, "--kind naming ")?,
            Kind::Thing => write!(formatter, "--kind thing ")?,
            Kind::Mask => write!(formatter, "--kind mask ")?,
        }
        write!(formatter, "--samples {samples} --seed {seed} --validate-every {validate_every}")?;
        if self.hold_out_poses {
            write!(formatter, " --hold-out-poses")?;
        }
        if self.recorded_percent < 100 {
            write!(formatter, " --recorded-poses {}", self.recorded_percent)?;
        }
        if let Some(hands) = self.hands {
            write!(formatter, " --hands {hands}")?;
        }
        if let Some(start) = start {
            write!(formatter, " --from the network {start:016x}")?;
        }
        if *optimiser == Optimiser::Adam {
            write!(formatter, " --optimiser adam")?;
        }
        if let Some(rate) = peak_rate {
            write!(formatter, " --rate {rate}")?;
        }
        if *keep_percent > 0 {
            write!(formatter, " --keep {keep_percent}")?;
        }
        left_out.iter().try_for_each(|kind| write!(formatter, " --without {}", kind.name()))
    }
}

impl Options {
    /// How many of a batch's samples are augmented hard at a step.
    pub(super) fn hard_samples(&self, batch: usize, step: u64, steps: u64) -> usize {
        if self.left_out.contains(&LeftOut::Hard) {
            return 0;
        }
        let most = match self.kind {
            Kind::Hand | Kind::Scene => HARD_AT_MOST,
            Kind::Naming | Kind::Thing | Kind::Mask => HARD_AT_MOST_NAMED,
        };
        let share = (HARD_AT_FIRST + HARDENING * step as f64 / steps as f64).min(most);
        (share * batch as f64).ceil() as usize
    }

    /// The learning rate after the warm-up.
    pub(super) fn peak_rate(&self) -> f32 {
        let usual = if self.start.is_some() { PEAK_RATE_OF_TRAINED } else { PEAK_RATE };
        self.peak_rate.unwrap_or(usual)
    }

    /// The recorded poses that are trained on.
    pub(super) fn poses(&self) -> PoseGroup {
        self.poses_of(self.recorded_percent)
    }

    /// Those that a training with all of the poses that are not held out is trained on: what is
    /// measured on them can be compared.
    pub(super) fn poses_to_measure(&self) -> PoseGroup {
        self.poses_of(100)
    }

    fn poses_of(&self, percent: u8) -> PoseGroup {
        if self.hold_out_poses { PoseGroup::Kept { percent } } else { PoseGroup::All }
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
