//! From the human's grasp to the robot's: the paper's Section VI.
//!
//! [`RobotHand`] says, as data, which of a robot hand's grasps does for each human grasp, and how
//! that is made; [`Object`] and [`Camera`] say what lies and stands where. [`Strategy`] puts them
//! together with a recognised hand into approach, grasp and retreat, which [`moveit`] writes for
//! ROS. An [`Arm`] says by which joint angles it carries the hand there.
//!
//! The feature `simulate` tries grasps in a physics engine; `schema` describes the types that stand
//! in records for OpenAPI. Both are off by default.
//!
//! # Frames
//!
//! Metres and radians; quaternions x, y, z, w. `world`: z up. `camera`: z forward, x right, y down.
//! `hand`: the human hand, x from the wrist to the middle knuckle, z out of the back, y = z cross
//! x. `palm`: the robot's, origin in the middle of its palm's surface, z the direction of approach,
//! y to the side of its thumb. `wrist`: the link that an arm carries, with the axes that its maker
//! gave it.
//! `object`: about the middle of its shape.

mod applicable;
mod approach_side;
mod arm;
mod attitude;
mod camera;
mod chain;
mod closing;
mod error;
mod face;
mod fault;
mod feasible;
mod finger;
mod fingerprint;
mod hand;
mod human;
mod layout;
pub mod moveit;
mod object;
mod outline;
mod placed;
mod pose;
mod read;
mod setting;
#[cfg(feature = "simulate")]
pub mod simulation;
mod step;
mod strategy;
mod tolerance;
mod urdf;
mod window;

pub use approach_side::ApproachSide;
pub use arm::{Arm, ArmMotion, Hindrance, Unreachable, Waypoint};
pub use camera::Camera;
pub use chain::Chain;
pub use error::RobotError;
pub use fault::{DescriptionFault, UrdfFault};
pub use feasible::{Problem, ProblemKind};
pub use finger::Finger;
pub use hand::{RobotGrasp, RobotHand, Travel, Value};
pub use layout::{LaidObject, Layout, View};
pub use object::{Frame, Object, Shape};
pub use pose::{Direction, Pose};
pub use read::described;
pub use setting::Setting;
pub use step::Step;
pub use strategy::{ObservedHand, Strategy};
pub use tolerance::Estimate;
pub use window::{LiesAlong, Window};

/// How the palm of a robot is turned in the frame of a human hand that it imitates: its z is the
/// hand's approach, its y points to the thumb's side.
///
/// # Errors
/// [`RobotError::UnknownHuman`]: the grasp is none of the six.
pub fn hand_from_palm(
    grasp: &str,
    side: grasp_recognise::Side,
) -> Result<nalgebra::UnitQuaternion<f64>, RobotError> {
    let human = human::HumanGrasp::named(grasp);
    human
        .map(|human| human.hand_from_palm(side))
        .ok_or_else(|| RobotError::UnknownHuman { grasp: grasp.to_owned() })
}
