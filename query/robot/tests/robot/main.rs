//! From a recognised hand to what a robot does: where the palm goes, what is tolerated, what cannot
//! be right, what is drawn and sent, by which joints an arm carries it, and bad input.

mod carried;
mod counterpart;
mod description;
mod feasible;
mod layout;
mod message;
mod placed;
mod tolerated;

use grasp_recognise::Side;
use grasp_robot::{Camera, Object, ObservedHand, Pose, ProblemKind, RobotHand, Strategy};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

const BOTTLE: &str = include_str!("../../../data/objects/bottle.toml");
const CAMERA: &str = include_str!("../../../data/objects/camera.toml");

fn hand(name: &str) -> RobotHand {
    RobotHand::find(name).unwrap()
}

fn bottle() -> Object {
    Object::parse("bottle.toml", BOTTLE).unwrap()
}

fn camera() -> Camera {
    Camera::parse("camera.toml", CAMERA).unwrap()
}

/// A right hand round an upright bottle: the thumb up, the palm coming along the world's x.
fn upright() -> UnitQuaternion<f64> {
    // Columns: where the hand's x, y, z point in the world.
    let axes = Matrix3::from_columns(&[-Vector3::y(), Vector3::z(), -Vector3::x()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes))
}

fn seen(grasp: &str, world_from_hand: UnitQuaternion<f64>, camera: &Camera) -> ObservedHand {
    let camera_from_hand = camera.world_from_camera.rotation.inverse() * world_from_hand;
    ObservedHand { grasp: grasp.into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 }
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z, w] = pose.quaternion_xyzw;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(pose.position.into(), rotation)
}

fn close(a: Vector3<f64>, b: Vector3<f64>) -> bool {
    (a - b).norm() < 1e-6
}

/// The hand that comes to the bottle from its side, tilted down by so much, in degrees.
fn tilted(degrees: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new(Vector3::y() * degrees.to_radians()) * upright()
}

fn kinds(strategy: &Strategy) -> Vec<ProblemKind> {
    assert_eq!(strategy.feasible, strategy.problems.is_empty());
    // Who reads warnings alone reads of every problem, and who reads both reads nothing twice.
    let messages = strategy.problems.iter().map(|problem| &problem.message);
    assert!(strategy.warnings.iter().zip(messages.clone()).all(|(warning, message)| warning == message));
    assert!(strategy.doubts().iter().all(|doubt| messages.clone().all(|message| message != doubt)));
    strategy.problems.iter().map(|problem| problem.kind).collect()
}
