//! Joint angles and directions as files give them.

use nalgebra::Vector3;
use serde::Deserialize;

use super::fault::GraspFault;
use crate::hand::{Digit, HandPose, JOINT_NAMES, Joints, joint_limits};

/// The joint angles of a hand in degrees, digit by digit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPose {
    pub(super) thumb: [f64; 5],
    pub(super) index: [f64; 4],
    pub(super) middle: [f64; 4],
    pub(super) ring: [f64; 4],
    pub(super) little: [f64; 4],
}

impl RawPose {
    /// The pose, if every angle is within its joint's limits; `pose` names it where one is not.
    pub(super) fn check(&self, pose: &str) -> Result<HandPose, GraspFault> {
        let four = |[a, b, c, d]: [f64; 4]| [a, b, c, d, 0.0];
        let raw = [self.thumb, four(self.index), four(self.middle), four(self.ring), four(self.little)];
        let mut digits: [Joints; 5] = [[0.0; 5]; 5];
        for (digit, (degrees, radians)) in Digit::ALL.into_iter().zip(raw.iter().zip(&mut digits)) {
            let names = JOINT_NAMES[usize::from(digit == Digit::Thumb)];
            let limits = joint_limits(digit);
            for joint in 0..names.len() {
                let [low, high] = limits[joint];
                let angle = degrees[joint].to_radians();
                if !(low - 1e-9..=high + 1e-9).contains(&angle) {
                    return Err(GraspFault::Angle {
                        pose: pose.to_owned(),
                        digit: digit.name(),
                        joint: names[joint],
                        degrees: degrees[joint],
                        low: low.to_degrees(),
                        high: high.to_degrees(),
                    });
                }
                radians[joint] = angle;
            }
        }
        Ok(HandPose { digits })
    }
}

/// A direction of unit length; `key` names it where it has none.
pub(super) fn unit(key: &'static str, v: [f64; 3]) -> Result<Vector3<f64>, GraspFault> {
    Vector3::from(v)
        .try_normalize(1e-6)
        .filter(|v| v.iter().all(|x| x.is_finite()))
        .ok_or(GraspFault::Direction(key))
}
