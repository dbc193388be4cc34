//! A wrist that bends.
//!
//! Renders for an index have straight wrists. In pictures that people take arms come from anywhere:
//! a hand that holds something up is bent back or to a side.

use nalgebra::{Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::random::normal;

/// The joint's middle in metres along x.
const JOINT: f32 = -0.005;
/// From here to there along x, in metres, skin goes along with the bending, more and more.
const FROM: f32 = 0.012;
const TO: f32 = -0.032;
/// Bending back and toward the little finger in degrees: mean, standard deviation, least and most.
/// The range of wrists of healthy people is about 70 degrees forward, 65 back, 20 toward the thumb
/// and 35 toward the little finger (A. I. Kapandji, "The Physiology of the Joints").
const BACK: [f64; 4] = [6.0, 20.0, -50.0, 55.0];
const SIDEWAYS: [f64; 4] = [3.0, 9.0, -18.0, 28.0];

/// How far a wrist is bent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wrist {
    /// The axis about which the arm is turned, its length the angle in radians.
    turn: Vector3<f32>,
}

impl Wrist {
    pub(super) const STRAIGHT: Self = Self { turn: Vector3::new(0.0, 0.0, 0.0) };

    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        let mut angle = |[mean, deviation, least, most]: [f64; 4]| {
            (mean + deviation * normal(rng)).clamp(least, most).to_radians() as f32
        };
        // About y the arm turns to the back of the hand, about z to the little finger's side.
        let (back, sideways) = (angle(BACK), angle(SIDEWAYS));
        Self { turn: Vector3::new(0.0, back, sideways) }
    }

    /// Where a point of a straight hand and arm comes to lie, and its normal.
    pub(super) fn bend(&self, point: &mut Vector3<f32>, normal: &mut Vector3<f32>) {
        let share = ((FROM - point.x) / (FROM - TO)).clamp(0.0, 1.0);
        if share == 0.0 {
            return;
        }
        let turn = Rotation3::new(self.turn * share);
        let joint = Vector3::new(JOINT, 0.0, 0.0);
        *point = joint + turn * (*point - joint);
        *normal = turn * *normal;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn the_arm_bends_and_the_hand_stays() {
        let back = Wrist { turn: Vector3::new(0.0, 0.5, 0.0) };
        let (mut finger, mut elbow) = (Vector3::new(0.1, 0.02, 0.0), Vector3::new(-0.3, 0.0, 0.0));
        let mut normal = Vector3::z();
        back.bend(&mut finger, &mut Vector3::z());
        back.bend(&mut elbow, &mut normal);
        assert_eq!(finger, Vector3::new(0.1, 0.02, 0.0));
        assert!(elbow.z > 0.1, "to the back of the hand: {elbow:?}");
        let along = (elbow - Vector3::new(JOINT, 0.0, 0.0)).normalize();
        assert!(along.dot(&normal).abs() < 1e-6);
        let (little, mut elbow) = (Wrist { turn: Vector3::new(0.0, 0.0, 0.5) }, Vector3::new(-0.3, 0.0, 0.0));
        little.bend(&mut elbow, &mut Vector3::z());
        assert!(elbow.y < -0.1, "to the little finger's side: {elbow:?}");
    }

    #[test]
    fn wrists_bend_as_far_as_peoples() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..500 {
            let mut elbow = Vector3::new(-0.3, 0.0, 0.0);
            Wrist::random(&mut rng).bend(&mut elbow, &mut Vector3::z());
            assert!(elbow.x < -0.1, "{elbow:?}");
        }
    }
}
