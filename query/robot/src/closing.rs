//! What the fingers do to an object that the palm has come to: whether it is between them while
//! they are open, and whether they meet it on their way to the closed posture.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};

use super::placed::{Placed, posture};
use super::{RobotGrasp, RobotHand, Shape};

/// Half of a finger's thickness, in metres, as the thickest of the built-in hands has it (the
/// Allegro Hand's tips are balls of 12 mm, the Barrett Hand's links 21 mm thick), and the way
/// between two postures that are looked at: a middle line that comes no nearer touches nothing.
const THICK: f64 = 0.015;
/// Between two points of a finger that are looked at, in metres.
const STEP: f64 = 0.005;
/// The way from the open to the closed posture is looked at in so many parts: a tip moves by less
/// than half of [`THICK`] in each.
const PARTS: u32 = 40;

/// What was found. Each pair: the fingers on the thumb's side, and those against them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closing {
    /// How far the middle line of an open finger is inside the object, in metres.
    pub(super) inside: [f64; 2],
    /// How near the middle line of a closing finger comes to it, in metres; infinite where there is
    /// no finger.
    pub(super) nearest: [f64; 2],
}

impl Closing {
    /// `None` for a hand whose description has no fingers.
    pub(super) fn new(
        hand: &RobotHand,
        grasp: &RobotGrasp,
        placed: &Placed,
        shape: &Shape,
        world_from_object: &Isometry3<f64>,
    ) -> Option<Self> {
        let object_from_palm = world_from_object.inverse() * placed.world_from_palm;
        let [open, closed] = [&grasp.open, &grasp.closed].map(|joints| posture(joints, placed.width));
        let fingers = |posture: &BTreeMap<String, f64>| {
            let mut fingers = hand.fingers(posture);
            fingers.retain(|finger| !finger.is_empty());
            fingers
        };
        let middle = grasp.middle.at(placed.width);
        let side = |finger: &Vec<Point3<f64>>| usize::from(finger.last().is_some_and(|tip| tip.y < middle));
        let sides: Vec<usize> = fingers(&open).iter().map(side).collect();
        if sides.is_empty() {
            return None;
        }
        let mut found = Self { inside: [0.0; 2], nearest: [f64::INFINITY; 2] };
        for (finger, side) in fingers(&open).iter().zip(&sides) {
            let depth = |point| shape.depth(&(object_from_palm * point));
            let deepest = along(finger).map(depth).fold(0.0, f64::max);
            found.inside[*side] = found.inside[*side].max(deepest);
        }
        for part in 0..=PARTS {
            let share = f64::from(part) / f64::from(PARTS);
            let between = open.iter().map(|(joint, from)| {
                let to = closed.get(joint).unwrap_or(from);
                (joint.clone(), from + share * (to - from))
            });
            for (finger, side) in fingers(&between.collect()).iter().zip(&sides) {
                let distance = |point| shape.distance(&(object_from_palm * point));
                let nearest = along(finger).map(distance).fold(f64::INFINITY, f64::min);
                found.nearest[*side] = found.nearest[*side].min(nearest);
            }
        }
        Some(found)
    }

    /// Whether fingers of both sides meet the object.
    pub(super) fn meets(&self) -> bool {
        self.nearest.iter().all(|metres| *metres < THICK)
    }

    /// How near the fingers come of the side that stays farther away, in metres; `None` where all
    /// fingers are on one side.
    pub(super) fn farther(&self) -> Option<f64> {
        Some(self.nearest.iter().copied().fold(0.0, f64::max)).filter(|metres| metres.is_finite())
    }
}

/// Points along a line.
fn along(line: &[Point3<f64>]) -> impl Iterator<Item = Point3<f64>> + '_ {
    let parts = line.windows(2).flat_map(|pair| match pair {
        [from, to] => {
            let steps = ((to - from).norm() / STEP).ceil().max(1.0) as u32;
            let part = move |step: u32| from + (to - from) * (f64::from(step) / f64::from(steps));
            (1..=steps).map(part).collect()
        }
        _ => Vec::new(),
    });
    line.first().copied().into_iter().chain(parts)
}
