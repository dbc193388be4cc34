//! Hands in none of the grasps.

use std::sync::Arc;

use grasp_renders::random::{normal, unit};
use grasp_renders::{Digit, Grasp, SceneSpec, joint_limits};
use rand_chacha::ChaCha8Rng;

/// How far all joints of a hand, and each by itself, are from relaxed, in radians (standard
/// deviation).
const COMMON: f64 = 0.3;
const OWN: f64 = 0.3;
const SPREAD: f64 = 0.12;
/// How often one finger is stretched or bent by itself, as one that points.
const POINTING: f64 = 0.3;

/// The scene's hand, relaxed, flat, pointing or half closed on nothing.
pub(super) fn posed(mut spec: SceneSpec, rng: &mut ChaCha8Rng) -> SceneSpec {
    let mut pose = spec.grasp.relaxed;
    let common = COMMON * normal(rng);
    let pointing = (unit(rng) < POINTING).then(|| ((unit(rng) * 5.0) as usize, normal(rng)));
    for digit in Digit::ALL {
        let alone = pointing.filter(|(which, _)| *which == digit as usize).map_or(0.0, |(_, bent)| bent);
        let limits = joint_limits(digit);
        for (joint, (angle, [low, high])) in pose.digits[digit as usize].iter_mut().zip(limits).enumerate() {
            let change = match joint {
                0 => SPREAD * normal(rng),
                _ => common + alone + OWN * normal(rng),
            };
            *angle = (*angle + change).clamp(low, high);
        }
    }
    // A hand that reaches is posed between relaxed and closed: here both are the same.
    let mut grasp = Grasp::clone(&spec.grasp);
    (grasp.relaxed, grasp.open, grasp.closed) = (pose, pose, pose);
    grasp.examples.clear();
    spec.grasp = Arc::new(grasp);
    spec.example = None;
    spec.held = Some(pose);
    spec
}
