//! Arms of any joints, solved step by step: Levenberg's damped least squares (1944), begun from
//! postures that are spread over the joints' ranges.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Isometry3, Matrix6, Vector3, Vector6};

use crate::chain::{Segment, frames};
use crate::read::Source;
use crate::{DescriptionFault, RobotError};

/// How many postures the search for the first pose begins from.
const BEGINNINGS: u32 = 96;
/// How many steps are tried before a pose counts as out of reach.
const STEPS: usize = 120;
/// A pose is reached where position (metres) and rotation (radians) are as near as this.
const NEAR: f64 = 1e-7;
/// What a radian counts beside a metre: an arm's length makes about so much of it.
const RADIAN: f64 = 0.3;
/// No joint turns farther in a step, in radians.
const STRIDE: f64 = 0.4;
/// Damping: at first, at least and at most.
const DAMPING: [f64; 3] = [1e-3, 1e-9, 1e3];
/// Postures whose joints differ by less, in radians (metres where they slide), are the same one.
const SAME: f64 = 1e-2;

/// An arm's joints, each with the limb behind it.
#[derive(Clone, Debug)]
pub(super) struct Limbs {
    segments: Vec<Segment>,
    joints: Vec<String>,
    limits: Vec<[f64; 2]>,
}

impl Limbs {
    /// # Errors
    /// [`RobotError::Format`]: a joint moves no segment or several, or a segment is not sound.
    pub(super) fn new(
        source: Source<'_>,
        segments: Vec<Segment>,
        joints: &[String],
        limits: &[[f64; 2]],
    ) -> Result<Self, RobotError> {
        if let Some(fault) = segments.iter().find_map(Segment::fault) {
            return Err(source.error(fault));
        }
        let moved =
            |name: &String| segments.iter().filter(|segment| segment.joint.as_ref() == Some(name)).count();
        if let Some(joint) = joints.iter().find(|joint| moved(joint) != 1) {
            let (joint, count) = (joint.clone(), moved(joint));
            return Err(source.error(DescriptionFault::SegmentsOfJoint { joint, count }));
        }
        let mut moving = segments.iter().filter_map(|segment| segment.joint.as_ref());
        if let Some(joint) = moving.find(|joint| !joints.contains(joint)) {
            return Err(source.error(DescriptionFault::StrayJoint(joint.clone())));
        }
        Ok(Self { segments, joints: joints.to_vec(), limits: limits.to_vec() })
    }

    /// Postures that bring the flange there, one of each sort that was found: within the joints'
    /// limits, or, where there is none of these, beyond them.
    pub(super) fn postures(&self, flange: &Isometry3<f64>) -> Vec<Vec<f64>> {
        let mut found: Vec<Vec<f64>> = Vec::new();
        for is_limited in [true, false] {
            for number in 0..BEGINNINGS {
                let reached = self.reach(flange, self.beginning(number), is_limited);
                if let Some(posture) =
                    reached.filter(|posture| found.iter().all(|other| self.differ(posture, other)))
                {
                    found.push(posture);
                }
            }
            if !found.is_empty() {
                break;
            }
        }
        found
    }

    /// The posture next to `last` that brings the flange there: within the joints' limits where
    /// there is one.
    pub(super) fn near(&self, flange: &Isometry3<f64>, last: &[f64]) -> Option<Vec<f64>> {
        self.reach(flange, last.to_vec(), true).or_else(|| self.reach(flange, last.to_vec(), false))
    }

    /// By how much a joint moves until the arm is as before; `None` of one that slides.
    pub(super) fn whole_turn(&self, joint: usize) -> Option<f64> {
        let name = self.joints.get(joint)?;
        let segment = self.segments.iter().find(|segment| segment.joint.as_ref() == Some(name))?;
        (!segment.slides && segment.factor != 0.0).then(|| TAU / segment.factor.abs())
    }

    /// Whether two postures are of different sorts, whole turns aside.
    fn differ(&self, one: &[f64], other: &[f64]) -> bool {
        one.iter().zip(other).enumerate().any(|(joint, (a, b))| {
            let apart = match self.whole_turn(joint) {
                Some(turn) => (a - b).rem_euclid(turn).min((b - a).rem_euclid(turn)),
                None => (a - b).abs(),
            };
            apart > SAME
        })
    }

    /// Postures that fill the joints' ranges evenly, however many are taken: Roberts' sequence, by
    /// the powers of the root of x^(d+1) = x + 1. Of a joint that turns over more than a turn a
    /// whole one about its middle is enough.
    fn beginning(&self, number: u32) -> Vec<f64> {
        let dimensions = self.limits.len();
        let root = (0..40).fold(2.0_f64, |root, _| (1.0 + root).powf(1.0 / (dimensions as f64 + 1.0)));
        let mut power = 1.0;
        let place = |(joint, [low, high]): (usize, &[f64; 2])| {
            power /= root;
            let share = (0.5 + power * f64::from(number)).fract();
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let half = self.whole_turn(joint).map_or(half, |turn| half.min(0.5 * turn));
            middle + half * (2.0 * share - 1.0)
        };
        self.limits.iter().enumerate().map(place).collect()
    }

    /// The posture that is reached from `posture`.
    fn reach(&self, flange: &Isometry3<f64>, posture: Vec<f64>, is_limited: bool) -> Option<Vec<f64>> {
        let [first, least, most] = DAMPING;
        let (mut posture, mut damping) = (posture, first);
        let (mut error, mut jacobian) = self.error(flange, &posture);
        for _ in 0..STEPS {
            // Not so with numbers that are none.
            if error.norm() < NEAR {
                return Some(posture);
            }
            let damped = &jacobian * jacobian.transpose() + DMatrix::identity(6, 6) * damping;
            let damped = Matrix6::from_iterator(damped.iter().copied());
            let step: DVector<f64> = jacobian.transpose() * damped.try_inverse()? * error;
            let stride = (STRIDE / step.amax().max(STRIDE)).min(1.0);
            let moved = posture.iter().zip(&step).zip(&self.limits);
            let next: Vec<f64> = moved
                .map(|((joint, step), [low, high])| {
                    let joint = joint + stride * step;
                    if is_limited { joint.clamp(*low, *high) } else { joint }
                })
                .collect();
            let (next_error, next_jacobian) = self.error(flange, &next);
            if next_error.norm() < error.norm() {
                (posture, error, jacobian) = (next, next_error, next_jacobian);
                damping = (damping / 4.0).max(least);
            } else if damping < most {
                damping *= 8.0;
            } else {
                return None;
            }
        }
        None
    }

    /// What is missing to the flange's pose, and how each joint moves it: position in metres, then
    /// rotation times [`RADIAN`], in the base's frame.
    fn error(&self, flange: &Isometry3<f64>, posture: &[f64]) -> (Vector6<f64>, DMatrix<f64>) {
        let place = |name: &str| self.joints.iter().position(|joint| joint == name);
        let value = |name: &str| place(name).and_then(|at| posture.get(at)).copied().unwrap_or_default();
        let frames = frames(&self.segments, value);
        let end = frames.last().copied().unwrap_or_else(Isometry3::identity);
        let missing = flange.translation.vector - end.translation.vector;
        let turn = (flange.rotation * end.rotation.inverse()).scaled_axis();
        let mut jacobian = DMatrix::zeros(6, self.joints.len());
        for (segment, frame) in self.segments.iter().zip(&frames) {
            let Some(column) = segment.joint.as_deref().and_then(place) else { continue };
            let axis: Vector3<f64> = frame.rotation * segment.axis().into_inner() * segment.factor;
            let (moved, turned) = match segment.slides {
                true => (axis, Vector3::zeros()),
                false => (axis.cross(&(end.translation.vector - frame.translation.vector)), axis),
            };
            jacobian.fixed_view_mut::<3, 1>(0, column).copy_from(&moved);
            jacobian.fixed_view_mut::<3, 1>(3, column).copy_from(&(turned * RADIAN));
        }
        let [x, y, z] = missing.into();
        let [a, b, c] = (turn * RADIAN).into();
        (Vector6::new(x, y, z, a, b, c), jacobian)
    }
}
