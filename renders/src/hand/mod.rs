//! A human right hand: its measures, its joints and its skin.
//!
//! The hand frame is the one of the whole project: origin at the wrist's centre, x toward the
//! middle knuckle, z out of the back of the hand, y toward the thumb; metres and radians.

mod shape;
mod skeleton;
mod surface;

pub use shape::{FingerMeasures, HandShape, HandShapeError};
pub(crate) use skeleton::{Chain, JOINTS};
pub use skeleton::{Digit, HandPose, JOINT_NAMES, Joints, Skeleton, joint_limits};
pub(crate) use surface::{HandSurface, WRIST_CUT};
