//! `vision_msgs`.

use serde::{Deserialize, Serialize};

use super::Message;
use super::geometry::PoseWithCovariance;
use super::standard::Header;

/// `vision_msgs/Detection2DArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Detection2DArray {
    pub(crate) header: Header,
    pub(crate) detections: Vec<Detection2D>,
}

impl Message for Detection2DArray {
    const TYPE: (&'static str, &'static str) = ("vision_msgs", "Detection2DArray");
}

/// `vision_msgs/Detection2D`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Detection2D {
    pub(crate) header: Header,
    pub(crate) results: Vec<ObjectHypothesisWithPose>,
    pub(crate) bbox: BoundingBox2D,
    pub(crate) id: String,
}

/// `vision_msgs/ObjectHypothesisWithPose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ObjectHypothesisWithPose {
    pub(crate) hypothesis: ObjectHypothesis,
    pub(crate) pose: PoseWithCovariance,
}

/// `vision_msgs/ObjectHypothesis`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ObjectHypothesis {
    pub(crate) class_id: String,
    pub(crate) score: f64,
}

/// `vision_msgs/BoundingBox2D`, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct BoundingBox2D {
    pub(crate) center: Pose2D,
    pub(crate) size_x: f64,
    pub(crate) size_y: f64,
}

/// `vision_msgs/Pose2D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pose2D {
    pub(crate) position: Point2D,
    pub(crate) theta: f64,
}

/// `vision_msgs/Point2D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point2D {
    pub(crate) x: f64,
    pub(crate) y: f64,
}
