//! `moveit_msgs` and `trajectory_msgs`. They are read from the fields that `grasp_robot::moveit`
//! names; what it leaves out is empty.

use serde::{Deserialize, Serialize};

use super::Message;
use super::geometry::{PoseStamped, Vector3Stamped};
use super::standard::{Header, Time};

/// `moveit_msgs/Grasp`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Grasp {
    pub(crate) id: String,
    pub(crate) pre_grasp_posture: JointTrajectory,
    pub(crate) grasp_posture: JointTrajectory,
    pub(crate) grasp_pose: PoseStamped,
    pub(crate) grasp_quality: f64,
    pub(crate) pre_grasp_approach: GripperTranslation,
    pub(crate) post_grasp_retreat: GripperTranslation,
    pub(crate) post_place_retreat: GripperTranslation,
    pub(crate) max_contact_force: f32,
    pub(crate) allowed_touch_objects: Vec<String>,
}

impl Message for Grasp {
    const TYPE: (&'static str, &'static str) = ("moveit_msgs", "Grasp");
}

/// `moveit_msgs/GripperTranslation`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct GripperTranslation {
    pub(crate) direction: Vector3Stamped,
    pub(crate) desired_distance: f32,
    pub(crate) min_distance: f32,
}

/// `trajectory_msgs/JointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct JointTrajectory {
    pub(crate) header: Header,
    pub(crate) joint_names: Vec<String>,
    pub(crate) points: Vec<JointTrajectoryPoint>,
}

/// `trajectory_msgs/JointTrajectoryPoint`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct JointTrajectoryPoint {
    pub(crate) positions: Vec<f64>,
    pub(crate) velocities: Vec<f64>,
    pub(crate) accelerations: Vec<f64>,
    pub(crate) effort: Vec<f64>,
    pub(crate) time_from_start: Time,
}
