//! Descriptors that a network has learned to make.

use super::planes::{PLANES_SIDE, Placement, planes, shown};
use crate::hand_image::HandImage;
use crate::rotation::from_columns;
use grasp_network::{Network, Scratch};
use nalgebra::UnitQuaternion;
use std::sync::Arc;

/// How many hands are remembered: one, and its mirror image.
const KNOWN: usize = 2;

/// A network and the memory that it runs in.
#[derive(Clone, Debug)]
pub(super) struct Learned {
    network: Arc<Network>,
    scratch: Scratch,
    planes: Vec<f32>,
    /// The hands that were described last, and what is shown of each: a hand and its mirror image
    /// are looked at several times, turned a little.
    shown: Vec<(HandImage, HandImage)>,
    opinion: Option<NetworkEstimate>,
}

impl Learned {
    pub(super) fn new(network: Arc<Network>) -> Self {
        Self {
            network,
            scratch: Scratch::default(),
            planes: vec![0.0; PLANES_SIDE * PLANES_SIDE * 2],
            shown: Vec::new(),
            opinion: None,
        }
    }

    /// The embedding of a hand that is turned by `turn_deg`, in as many values as `out` has.
    pub(super) fn describe(&mut self, hand: &HandImage, turn_deg: f64, out: &mut [f32]) {
        let placement = Placement::turned(turn_deg.to_radians());
        let known = self.shown.iter().position(|(known, _)| known == hand);
        let known = known.unwrap_or_else(|| {
            self.shown.truncate(KNOWN - 1);
            self.shown.insert(0, (hand.clone(), shown(hand)));
            0
        });
        planes(&self.shown[known].1, &placement, &mut self.planes);
        let output = self.network.run(&mut self.scratch, &self.planes);
        for (value, embedded) in out.iter_mut().zip(output.embedding) {
            *value = *embedded;
        }
        self.opinion = NetworkEstimate::of_heads(output.heads);
    }

    /// What the network itself says of the last picture.
    pub(super) fn opinion(&self) -> Option<&NetworkEstimate> {
        self.opinion.as_ref()
    }
}

/// Stages that networks are trained on: reach, close, grasp.
pub const NETWORK_STAGES: [&str; 3] = ["reach", "close", "grasp"];
/// Of the heads, those that follow the stages: the rotation.
const ROTATION: usize = 6;

/// What a network says of the last picture by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkEstimate {
    /// How probable each class is if the hand is a right one; all sum to 1.
    pub classes: Vec<f64>,
    /// How probably the picture shows the mirror image of a right hand, 0 to 1.
    pub mirrored: f64,
    /// How probable each stage is: reach, close and grasp; all sum to 1.
    pub stages: [f64; NETWORK_STAGES.len()],
    /// `camera_from_hand` of the picture as it was turned to be looked at.
    pub rotation: Option<UnitQuaternion<f64>>,
}

impl NetworkEstimate {
    /// The heads are the classes, one more for a hand that is mirrored, the stages and the
    /// rotation; `None` of a network with other heads.
    fn of_heads(heads: &[f32]) -> Option<Self> {
        let (heads, columns) = heads.split_last_chunk::<ROTATION>()?;
        let (logits, stages) = heads.split_last_chunk::<{ NETWORK_STAGES.len() }>()?;
        let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let likelihood = |logit: &f32| libm::exp(f64::from(logit - largest));
        let (mirrored, classes) = logits.split_last()?;
        // At least the smallest number, so that 0 / 0 cannot occur.
        let sum = classes.iter().map(likelihood).sum::<f64>().max(f64::MIN_POSITIVE);
        let mirrored = likelihood(mirrored);
        let highest = stages.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let stages = stages.map(|logit| libm::exp(f64::from(logit - highest)));
        let all: f64 = stages.iter().sum();
        Some(Self {
            stages: stages.map(|likelihood| likelihood / all),
            classes: classes.iter().map(|logit| likelihood(logit) / sum).collect(),
            mirrored: mirrored / (mirrored + sum),
            rotation: from_columns(*columns),
        })
    }
}
