//! `geometry_msgs`.

use serde::{Deserialize, Serialize};

use super::Message;
use super::standard::Header;

/// `geometry_msgs/Point`, and `Vector3`, whose fields are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Quaternion {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
    pub(crate) w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/Pose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pose {
    pub(crate) position: Point,
    pub(crate) orientation: Quaternion,
}

/// `geometry_msgs/PoseStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PoseStamped {
    pub(crate) header: Header,
    pub(crate) pose: Pose,
}

impl Message for PoseStamped {
    const TYPE: (&'static str, &'static str) = ("geometry_msgs", "PoseStamped");
}

/// `geometry_msgs/PoseWithCovariance`; the covariance row by row: x, y, z, and the turns about
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PoseWithCovariance {
    pub(crate) pose: Pose,
    pub(crate) covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/Vector3Stamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Vector3Stamped {
    pub(crate) header: Header,
    pub(crate) vector: Point,
}
