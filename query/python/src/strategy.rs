//! What a robot does to make the same grasp.

use std::path::PathBuf;

use grasp_recognise::Side;
use grasp_robot::{Arm, Camera, Object, ObservedHand, RobotError, RobotHand, Setting, Strategy};
use nalgebra::{Quaternion, UnitQuaternion};
use pyo3::prelude::*;

use crate::error::{self, parameter};

/// The strategy that imitates a hand, as JSON; `grasp.strategy` says what it takes.
#[pyfunction]
#[pyo3(signature = (grasp, hand, quaternion_xyzw, spread_deg, robot, object, camera, arm=None))]
#[allow(clippy::too_many_arguments, reason = "what is seen, and what is there")]
pub(crate) fn strategy(
    py: Python<'_>,
    grasp: String,
    hand: &str,
    quaternion_xyzw: [f64; 4],
    spread_deg: f64,
    robot: &str,
    object: PathBuf,
    camera: PathBuf,
    arm: Option<&str>,
) -> PyResult<String> {
    let side = match hand {
        "left" => Side::Left,
        "right" => Side::Right,
        other => return Err(parameter(format!("hand is {other:?}: \"left\" or \"right\" is needed"))),
    };
    let [x, y, z, w] = quaternion_xyzw;
    // To the last bit what the answer says.
    let camera_from_hand = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let seen = ObservedHand { grasp, side, camera_from_hand, spread_deg };
    let made = py.detach(|| -> Result<Strategy, RobotError> {
        let (hand, object, camera) =
            (RobotHand::find(robot)?, Object::read(&object)?, Camera::read(&camera)?);
        let arm = arm.map(Arm::find).transpose()?;
        Setting::new(hand, object, camera)?.with_arm(arm).strategy(&seen)
    });
    let made = made.map_err(|cause| error::failure(&cause))?;
    serde_json::to_string(&made).map_err(|cause| error::failure(&cause))
}
