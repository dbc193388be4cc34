//! Joints one after the other, each with the link behind it, as URDF describes them: the fingers of
//! a hand, and arms.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::DescriptionFault;

/// The longest part of a finger or of an arm, in metres.
const LONGEST: f64 = 2.0;
/// An axis whose length is less has no direction.
const SHORTEST_AXIS: f64 = 1e-3;

/// A joint and the link behind it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Segment {
    /// Where its frame is in that of the segment before, in metres.
    #[serde(default)]
    pub(super) at: [f64; 3],
    /// How it is turned there: roll, pitch and yaw about the fixed axes x, y, z, in radians.
    #[serde(default)]
    pub(super) rpy: [f64; 3],
    /// The joint that moves it; none where it is fixed.
    pub(super) joint: Option<String>,
    /// The axis about which the joint turns, or along which it slides, in its own frame.
    #[serde(default = "z")]
    pub(super) axis: [f64; 3],
    /// Whether the joint slides.
    #[serde(default)]
    pub(super) slides: bool,
    /// By how much it moves for 1 of the joint: something else than 1 where it follows another one.
    #[serde(default = "one")]
    pub(super) factor: f64,
    /// How far it has moved where the joint says 0.
    #[serde(default)]
    pub(super) plus: f64,
}

fn z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn one() -> f64 {
    1.0
}

impl Segment {
    /// Its joint's axis, of unit length.
    pub(super) fn axis(&self) -> Unit<Vector3<f64>> {
        Unit::try_new(self.axis.into(), SHORTEST_AXIS).unwrap_or_else(Vector3::z_axis)
    }

    /// From the segment before, with its joint at `value`.
    fn moved(&self, value: f64) -> Isometry3<f64> {
        let [roll, pitch, yaw] = self.rpy;
        let origin = Isometry3::from_parts(
            Translation3::from(self.at),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        );
        if self.joint.is_none() {
            return origin;
        }
        let (axis, way) = (self.axis(), self.factor * value + self.plus);
        match self.slides {
            true => origin * Translation3::from(axis.scale(way)),
            false => origin * UnitQuaternion::from_axis_angle(&axis, way),
        }
    }

    /// What is wrong with its description.
    pub(super) fn fault(&self) -> Option<DescriptionFault> {
        // Written so that what is not a number is rejected as well.
        let is_sound = self.at.iter().all(|metres| metres.abs() <= LONGEST)
            && self.rpy.iter().all(|radians| radians.abs() <= std::f64::consts::TAU)
            && (self.factor.abs() <= 100.0 && self.plus.abs() <= 100.0);
        if !is_sound {
            return Some(DescriptionFault::Segment { at: self.at, longest: LONGEST });
        }
        let length = Vector3::from(self.axis).norm();
        // As above.
        (!(length > SHORTEST_AXIS && length.is_finite())).then_some(DescriptionFault::SegmentAxis(self.axis))
    }
}

/// The frame of every segment in the frame that the first begins in; `value` says where a joint is.
pub(super) fn frames(segments: &[Segment], value: impl Fn(&str) -> f64) -> Vec<Isometry3<f64>> {
    let mut frame = Isometry3::identity();
    segments
        .iter()
        .map(|segment| {
            frame *= segment.moved(segment.joint.as_deref().map_or(0.0, &value));
            frame
        })
        .collect()
}

/// A finger as a chain of joints in the wrist's frame.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    /// From the wrist to the tip.
    segments: Vec<Segment>,
}

impl Chain {
    /// The finger's middle line in the wrist's frame, from its first joint to its tip, its joints
    /// being as `posture` says.
    pub(super) fn points(&self, posture: &BTreeMap<String, f64>) -> Vec<Point3<f64>> {
        let value = |joint: &str| posture.get(joint).copied().unwrap_or_default();
        frames(&self.segments, value).iter().map(|frame| frame.translation.vector.into()).collect()
    }

    /// What is wrong with its description, for a hand whose joints are those of `limits`.
    pub(super) fn fault(&self, limits: &BTreeMap<String, [f64; 2]>) -> Option<DescriptionFault> {
        if self.segments.is_empty() {
            return Some(DescriptionFault::NoSegments);
        }
        let joints = self.segments.iter().filter_map(|segment| segment.joint.as_ref());
        if let Some(joint) = joints.into_iter().find(|joint| !limits.contains_key(*joint)) {
            return Some(DescriptionFault::ChainJoint(joint.clone()));
        }
        self.segments.iter().find_map(Segment::fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(text: &str) -> Chain {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn links_follow_their_joints() {
        // A link along x that turns about z, and one that slides out of its end and follows twice.
        let finger = chain(
            r#"segments = [
                { joint = "turn" },
                { at = [0.1, 0.0, 0.0], joint = "turn", axis = [2.0, 0.0, 0.0], slides = true, factor = 0.02, plus = 0.01 },
                { at = [0.0, 0.0, 0.05], rpy = [0.0, 1.5707963267948966, 0.0] },
            ]"#,
        );
        let quarter = std::f64::consts::FRAC_PI_2;
        let points = finger.points(&[("turn".to_owned(), quarter)].into());
        let slid = 0.02 * quarter + 0.01;
        for (found, expected) in
            points.iter().zip([[0.0; 3], [0.0, 0.1 + slid, 0.0], [0.0, 0.1 + slid, 0.05]])
        {
            assert!((found - Point3::from(expected)).norm() < 1e-12, "{found} {expected:?}");
        }
        let limits: BTreeMap<_, _> = [("turn".to_owned(), [0.0, quarter])].into();
        assert_eq!(finger.fault(&limits), None);
    }

    #[test]
    fn what_has_no_direction_or_no_joint_is_refused() {
        let limits = BTreeMap::new();
        for (text, words) in [
            ("segments = []", "needs segments"),
            ("segments = [{ joint = 'a' }]", "`a` is no joint"),
            ("segments = [{ axis = [0.0, 0.0, 0.0] }]", "no direction"),
            ("segments = [{ axis = [inf, 0.0, 0.0] }]", "no direction"),
            ("segments = [{ at = [nan, 0.0, 0.0] }]", "metres within"),
            ("segments = [{ factor = 1e9 }]", "factor"),
        ] {
            let fault = chain(text).fault(&limits).unwrap();
            assert!(fault.to_string().contains(words), "{text}: {fault}");
        }
    }
}
