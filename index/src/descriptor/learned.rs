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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::from_euler_deg;
    use grasp_network::Architecture;

    #[test]
    fn no_more_hands_are_remembered_than_a_hand_and_its_mirror_image() {
        let architecture = Architecture {
            side: PLANES_SIDE as u32,
            planes: 2,
            convolutions: Vec::new(),
            embedding: 2,
            heads: 3,
            masks: None,
        };
        let count = architecture.parameters().expect("a small network");
        let network = Network::from_weights(architecture, vec![0.1; count]).expect("a network");
        let mut learned = Learned::new(Arc::new(network));
        let hand = |grey: u8| HandImage::from_mask(8, 9, &[grey; 72], &[1; 72]).expect("a hand");
        for grey in [1, 2, 3, 1, 2] {
            learned.describe(&hand(grey), 0.0, &mut [0.0; 2]);
        }
        let known: Vec<&HandImage> = learned.shown.iter().map(|(known, _)| known).collect();
        assert_eq!(known, [&hand(2), &hand(1)]);
    }

    #[test]
    fn heads_are_classes_the_mirrored_hand_stages_and_a_rotation() {
        let rotation = from_euler_deg([20.0, -40.0, 130.0]);
        let columns: Vec<f32> =
            rotation.to_rotation_matrix().matrix().as_slice()[..6].iter().map(|v| *v as f32).collect();
        let ln = |value: f64| libm::log(value) as f32 + 90.0;
        let mut heads = [6.0, 2.0, 24.0, 1.0, 5.0, 2.0].map(ln).to_vec();
        heads.extend(columns);
        let near =
            |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        let said = NetworkEstimate::of_heads(&heads).expect("two classes");
        assert!(said.classes.len() == 2 && near(&said.classes, &[0.75, 0.25]), "{said:?}");
        // Of all three, the mirrored hand among them.
        assert!(near(&[said.mirrored], &[0.75]), "{said:?}");
        assert!(near(&said.stages, &[0.125, 0.625, 0.25]), "{said:?}");
        assert!(said.rotation.expect("a rotation").angle_to(&rotation) < 1e-6);
        // However sure it is, and whatever of.
        heads[..6].copy_from_slice(&[-900.0, -900.0, 900.0, 0.0, 900.0, -900.0]);
        let said = NetworkEstimate::of_heads(&heads).expect("two classes");
        assert!(said.mirrored == 1.0 && said.stages == [0.0, 1.0, 0.0], "{said:?}");
        assert!(said.classes.iter().all(|share| (0.0..=1.0).contains(share)), "{said:?}");
        assert_eq!(NetworkEstimate::of_heads(&heads[..9]), None);
    }
}
