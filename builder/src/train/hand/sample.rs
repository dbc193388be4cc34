//! One picture to learn from.

use std::sync::Arc;

use grasp_index::{
    HandImage, PLANES_SIDE, PLANES_SOURCE_SIDE, Placement, SHOWN_LENGTHS, planes, shown, turned_orientation,
};
use grasp_renders::random::{normal, unit};
use grasp_renders::{Render, Stage};
use grasp_train::{LossWeights, Target};
use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::augment::{Picture, augment};
use crate::train::joints::Joints;
use crate::train::rotation;

/// How far a picture's turn differs from the upright one, in radians (standard deviation).
const TURN: f64 = 0.25;
/// How often it stands upside down, as where the thinner end is not the arm's.
const UPSIDE_DOWN: f64 = 0.2;
/// How often it is turned by any angle.
const ANY_TURN: f64 = 0.1;
/// Standard deviation of the stretch's logarithm and of the shear.
const STRETCH: f64 = 0.07;
/// Standard deviation of the logarithms of the zoom and of how much of the arm is shown.
const ZOOM: f64 = 0.08;
/// Standard deviation of the shift, in shares of the square.
const SHIFT: f64 = 0.03;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Labels {
    /// The grasp's place in the list of classes.
    pub class: usize,
    /// How far the grasp is closed.
    pub stage: Stage,
    /// The hand's orientation `camera_from_hand` on the picture.
    pub orientation: UnitQuaternion<f64>,
}

impl Labels {
    /// What a network shall answer.
    pub fn target(&self) -> Target {
        Target {
            class: self.class as u32,
            stage: self.stage as u32,
            rotation: rotation::rows(&self.orientation),
            weights: LossWeights::ALL,
        }
    }

    /// What it shall answer to the picture's mirror image, among `classes` classes: the one
    /// beyond them, a hand that is mirrored. Of its stage and rotation nothing is asked.
    pub fn target_mirrored(&self, classes: usize) -> Target {
        let weights = LossWeights { stage: 0.0, rotation: 0.0, joints: 0.0, ..LossWeights::ALL };
        Target { class: classes as u32, weights, ..self.target() }
    }
}

/// A render and what it shows.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Pixels a side.
    side: usize,
    /// Row by row, 0 outside the hand.
    grey: Vec<u8>,
    labels: Labels,
    joints: Arc<Joints>,
}

/// A picture as a network is shown it.
#[derive(Clone, Debug)]
pub struct Shown {
    /// See [`planes`].
    pub planes: Vec<f32>,
    /// What it shows, turned as the picture is.
    pub labels: Labels,
}

impl Shown {
    /// The picture's mirror image, left to right. The labels stay those of the hand.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        for row in self.planes.chunks_exact_mut(2 * PLANES_SIDE) {
            let (pixels, _) = row.as_chunks_mut::<2>();
            pixels.reverse();
        }
        self
    }
}

impl Sample {
    /// A render of a class.
    pub fn new(render: Render, class: usize, stage: Stage, joints: Arc<Joints>) -> Self {
        let labels = Labels { class, stage, orientation: render.camera_from_hand };
        Self { side: render.side, grey: render.grey, labels, joints }
    }

    /// The picture as a query would be shown: upright, otherwise as it is. `None` of a hand that is
    /// too small to be described.
    pub fn plain(&self) -> Option<Shown> {
        let hand = HandImage::from_segmented(self.side, self.side, &self.grey, 0).ok()?;
        let hand = hand.shrunk_to(PLANES_SOURCE_SIDE);
        let turn = hand.upright_turn_deg().to_radians();
        Some(self.show(&shown(&hand), turn, &Placement::turned(turn)))
    }

    /// The picture a little displaced and distorted, and, where `hard`, in another light, with
    /// another border, behind other things. `None` of a hand that is too small to be described.
    pub fn varied(&self, hard: bool, rng: &mut ChaCha8Rng) -> Option<Shown> {
        let mut picture = Picture::new(self.side, &self.grey);
        if hard {
            let arm = self.labels.orientation * -Vector3::x();
            augment(&mut picture, [arm.x as f32, arm.y as f32], rng);
        }
        let hand = picture.hand().or_else(|| Picture::new(self.side, &self.grey).hand())?;
        let hand = hand.shrunk_to(PLANES_SOURCE_SIDE);
        let upright = hand.upright_turn_deg();
        let hand = hand.without_arm(upright, SHOWN_LENGTHS * libm::exp(ZOOM * normal(rng)));
        let mut turn = upright.to_radians() + TURN * normal(rng);
        let way = unit(rng);
        if way < UPSIDE_DOWN {
            turn += std::f64::consts::PI;
        } else if way < UPSIDE_DOWN + ANY_TURN {
            turn = std::f64::consts::TAU * unit(rng);
        }
        Some(self.show(&hand, turn, &displaced(turn, rng)))
    }

    /// Where the hand's joints are on a picture of it.
    pub(super) fn joints(&self, shown: &Shown) -> Vec<f32> {
        self.joints.values(&shown.labels.orientation)
    }

    /// The hand placed on the square by a `placement` that turns it by `turn` radians.
    fn show(&self, hand: &HandImage, turn: f64, placement: &Placement) -> Shown {
        let mut shown = vec![0.0; 2 * PLANES_SIDE * PLANES_SIDE];
        planes(hand, placement, &mut shown);
        let orientation = turned_orientation(turn.to_degrees(), &self.labels.orientation);
        Shown { planes: shown, labels: Labels { orientation, ..self.labels } }
    }
}

/// About where a hand that is turned by `turn` radians belongs, stretched and sheared a little.
fn displaced(turn: f64, rng: &mut ChaCha8Rng) -> Placement {
    let mut placement = Placement::turned(turn);
    let (stretch, shear) = (libm::exp(STRETCH * normal(rng)), STRETCH * normal(rng));
    let [across, down] = placement.map;
    let across = across.map(|v| v * stretch);
    let down = down.map(|v| v / stretch);
    placement.map = [[across[0] + shear * down[0], across[1] + shear * down[1]], down];
    placement.zoom = libm::exp(ZOOM * normal(rng));
    placement.shift = [SHIFT * normal(rng), SHIFT * normal(rng)];
    placement
}
