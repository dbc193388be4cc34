//! Plans the joint angles that carry the hand along a way.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::described::Arm;
use super::motion::{ArmMotion, Hindrance, Unreachable, Waypoint};
use crate::pose::{Pose, rounded};
use crate::step::Step;

/// At most so far apart, in metres, are two waypoints of a straight way.
const SPACING: f64 = 0.01;
/// A joint that turns farther than this between two waypoints, in radians, has to turn over: no
/// straight way for the hand.
const LEAP: f64 = 0.5;

/// Every joint's angle, in radians.
type Posture = Vec<f64>;

/// A pose on the way.
struct Station {
    step: &'static str,
    distance: f64,
    /// In the base's frame.
    flange: Isometry3<f64>,
}

impl Arm {
    /// The joint angles along the approach and the retreat of `steps`, whose grasp has the wrist at
    /// `wrist` in the world and approaches along `forward`, of unit length there: of the ways that
    /// keep every joint within its limits and turn none of them over, the one on which the joints
    /// turn least.
    pub fn carry(&self, wrist: &Pose, forward: Vector3<f64>, steps: &[Step]) -> ArmMotion {
        let stations = self.stations(wrist, forward, steps);
        let mut best: Option<(f64, Vec<Posture>)> = None;
        let mut farthest = (0, Hindrance::OutOfReach);
        let starts = stations.first().map(|start| self.solver.postures(&start.flange)).unwrap_or_default();
        if !starts.is_empty() {
            farthest.1 = Hindrance::JointLimit;
        }
        for start in starts.iter().filter_map(|joints| self.within(joints)) {
            match self.follow(start, &stations) {
                Ok((turned, way)) => {
                    if best.as_ref().is_none_or(|(least, _)| turned < *least) {
                        best = Some((turned, way));
                    }
                }
                Err(end) if end.0 > farthest.0 => farthest = end,
                Err(_) => {}
            }
        }
        let motion = |waypoints: Vec<Waypoint>, unreachable: Option<Unreachable>| ArmMotion {
            arm: self.name.clone(),
            joint_names: self.joints.clone(),
            reachable: unreachable.is_none(),
            waypoints,
            unreachable,
        };
        match (best, stations.get(farthest.0)) {
            (Some((_, way)), _) => motion(
                stations
                    .iter()
                    .zip(way)
                    .map(|(station, joints)| Waypoint {
                        step: station.step,
                        distance: rounded(station.distance),
                        joints: joints.into_iter().map(rounded).collect(),
                    })
                    .collect(),
                None,
            ),
            (None, station) => {
                let (step, distance) =
                    station.map_or(("approach", 0.0), |station| (station.step, station.distance));
                let distance = rounded(distance);
                motion(Vec::new(), Some(Unreachable { step, distance, why: farthest.1 }))
            }
        }
    }

    /// Where the flange has to be: along the approach, then along the retreat.
    fn stations(&self, wrist: &Pose, forward: Vector3<f64>, steps: &[Step]) -> Vec<Station> {
        let grasp = wrist.isometry();
        let mut stations = Vec::new();
        let mut straight = |step, length: f64, from: Isometry3<f64>, direction: Vector3<f64>| {
            let parts = (length / SPACING).ceil().max(1.0);
            for part in 0..=parts as usize {
                let distance = length * part as f64 / parts;
                let wrist = Translation3::from(direction * distance) * from;
                let flange = self.base_from_world * wrist * self.wrist_from_flange;
                stations.push(Station { step, distance, flange });
            }
        };
        for step in steps {
            match step {
                Step::Approach { distance, .. } => {
                    let start = Translation3::from(-forward * *distance) * grasp;
                    straight("approach", *distance, start, forward);
                }
                Step::Retreat { distance, direction, .. } => {
                    straight("retreat", *distance, grasp, direction.vector.into());
                }
                Step::Preshape { .. } | Step::Grasp { .. } => {}
            }
        }
        stations
    }

    /// All stations from the joints of the first one, and how far the joints turn in all; or the
    /// station that was not reached and why.
    fn follow(
        &self,
        start: Vec<f64>,
        stations: &[Station],
    ) -> Result<(f64, Vec<Posture>), (usize, Hindrance)> {
        let mut way = vec![start.clone()];
        let mut turned = 0.0;
        let mut last = start;
        for (at, station) in stations.iter().enumerate().skip(1) {
            let solutions = self.solver.near(&station.flange, &last);
            if solutions.is_empty() {
                return Err((at, Hindrance::OutOfReach));
            }
            let turn = |joints: &[f64]| {
                joints.iter().zip(&last).map(|(joint, last)| (joint - last).abs()).fold(0.0, f64::max)
            };
            let next = solutions
                .iter()
                .filter(|joints| self.allows(joints))
                .min_by(|one, other| turn(one).total_cmp(&turn(other)))
                .ok_or((at, Hindrance::JointLimit))?;
            if turn(next) > LEAP {
                // Where the way that goes on is beyond a limit, that is what is in the way.
                let limited = solutions.iter().any(|joints| turn(joints) <= LEAP);
                return Err((at, if limited { Hindrance::JointLimit } else { Hindrance::Leap }));
            }
            turned += next.iter().zip(&last).map(|(joint, last)| (joint - last).abs()).sum::<f64>();
            last = next.clone();
            way.push(last.clone());
        }
        Ok((turned, way))
    }

    /// The same posture with every joint within its limits, as near to their middle as whole turns
    /// allow.
    fn within(&self, joints: &[f64]) -> Option<Vec<f64>> {
        let mut turned = joints.to_vec();
        for (at, (joint, [low, high])) in turned.iter_mut().zip(&self.limits).enumerate() {
            if let Some(turn) = self.solver.whole_turn(at) {
                *joint += turn * (((low + high) / 2.0 - *joint) / turn).round();
            }
        }
        self.allows(&turned).then_some(turned)
    }

    fn allows(&self, joints: &[f64]) -> bool {
        joints.iter().zip(&self.limits).all(|(joint, [low, high])| (low..=high).contains(&joint))
    }
}
