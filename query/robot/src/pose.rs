//! Poses and directions, each in a named frame.

use grasp_recognise::orientation::xyzw;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::Serialize;

/// A position and a rotation in a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Pose {
    /// `object` (about its middle) or `world`.
    pub frame: &'static str,
    /// Metres.
    pub position: [f64; 3],
    /// A unit quaternion, x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
}

/// A unit vector in a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Direction {
    /// `object`, `world`, or a link of the robot.
    pub frame: String,
    /// Of length 1.
    pub vector: [f64; 3],
}

impl Pose {
    pub(super) fn new(frame: &'static str, pose: &Isometry3<f64>) -> Self {
        Self { frame, position: pose.translation.vector.into(), quaternion_xyzw: xyzw(&pose.rotation) }
    }

    /// The same as a rigid motion.
    pub(super) fn isometry(&self) -> Isometry3<f64> {
        let [x, y, z, w] = self.quaternion_xyzw;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(self.position), rotation)
    }
}

/// To a micrometre or microradian: what lies beyond is noise that would differ between machines.
/// Never -0.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}
