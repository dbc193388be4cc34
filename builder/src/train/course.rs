//! What a network is taught.

use std::sync::Arc;

use grasp_network::{Architecture, Network};
use grasp_renders::HandModel;
use grasp_terminal::Work;
use grasp_train::{Factors, Target};
use rand_chacha::ChaCha8Rng;

use super::figures::Figure;
use super::{Check, Options, Schedule};

/// A kind of network: the renders that it is trained on, what is made of them at each showing, and
/// how it is measured.
pub trait Course: Sized + Sync {
    /// What is rendered once and shown several times.
    type Render: Send + Sync;
    /// Renders to measure by.
    type Validation: Sync;

    /// What a training with these options teaches.
    fn new(options: &Options) -> Self;

    /// The network that learns it.
    fn architecture(&self) -> Architecture;

    /// The weight of each loss.
    fn factors(&self) -> Factors {
        Factors::default()
    }

    /// Renders `views` views of a scene of an endless list. The same number has the same renders.
    ///
    /// # Errors
    /// Where the scene cannot be built.
    fn render(&self, number: u64, views: usize) -> anyhow::Result<Vec<Self::Render>>;

    /// What the network is shown of a render, other than ever before. `None` where too little of a
    /// hand is left.
    fn lesson(&self, render: &Self::Render, showing: Showing, rng: &mut ChaCha8Rng) -> Option<Lesson>;

    /// How many scenes [`Self::validation`] renders.
    fn validation_scenes(schedule: &Schedule) -> u64;

    /// Renders what a network is measured by: hands that no training draws, or `hand_model` in
    /// their place.
    ///
    /// # Errors
    /// Where a scene cannot be built, or `check` has stopped the work.
    fn validation(
        &self,
        schedule: &Schedule,
        hand_model: Option<&Arc<HandModel>>,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<Self::Validation>;

    /// How well a network does.
    fn measure(&self, validation: &Self::Validation, network: &Network) -> Vec<Figure>;
}

/// How a render is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Showing {
    /// Made harder than most, where a course knows of such a thing.
    pub is_hard: bool,
    /// As its mirror image, left to right.
    pub is_mirrored: bool,
}

/// One sample of a batch.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// The network's input.
    pub planes: Vec<f32>,
    /// What it shall answer.
    pub target: Target,
    /// The masks that it shall answer; empty for a network without.
    pub masks: Vec<f32>,
    /// Where the hand's joints are, as seen and as bent.
    pub joints: Vec<f32>,
}
