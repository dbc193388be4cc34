//! An answer and all that led to it.

use grasp_index::HandImage;
use nalgebra::UnitQuaternion;

use crate::accept::Doubt;
use crate::evidence::Evidence;
use crate::hypothesis::Hypothesis;
use crate::source::Prepared;
use crate::timings::Timings;
use crate::warning::Warning;

/// What is known besides a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Context {
    /// Nothing.
    #[default]
    Nothing,
    /// How the object that the hand holds is usually grasped.
    Object,
    /// The frames before it.
    Frames,
}

/// An answer and all that led to it.
#[derive(Clone, Debug)]
pub struct Recognition {
    /// The picture and its mask.
    pub prepared: Prepared,
    /// The hand image, as the picture shows it.
    pub hand_image: HandImage,
    /// The best hypothesis about hand and roll, with its neighbours and their vote.
    pub best: Hypothesis,
    /// What picture and neighbours say about how far the answer can be relied on.
    pub evidence: Evidence,
    /// How far the answer is trusted, 0..=1. `None` where the mask was given and is one.
    pub trust: Option<f64>,
    /// What the probabilities of the vote were tempered by for that, 0..=1, where they were.
    pub tempering: Option<f64>,
    /// How networks see the hand turned in the picture, by each of their looks; empty where none
    /// looks, or the orientation is the neighbours' alone.
    pub(crate) seen: Vec<UnitQuaternion<f64>>,
    /// How the same hand is turned by variants of the picture, where these were looked at.
    pub(crate) seen_in_variants: Vec<UnitQuaternion<f64>>,
    /// How likely the hand is in none of the grasps, by all that is seen, 0..=1; `None` where no
    /// scene network has found it.
    pub no_grasp: Option<f64>,
    /// What should make a reader doubt the answer.
    pub warnings: Vec<Warning>,
    /// Why the class is unknown, where it is.
    pub doubt: Option<Doubt>,
    /// What the answer goes by besides the picture.
    pub context: Context,
    /// How long each step took.
    pub timings: Timings,
}
