//! The grasps: data, not code. A grasp says how the hand opens and closes, what it holds, where,
//! and how it is held in the world; the fingers then close on the object by themselves until they
//! touch.

mod definition;
mod example;
mod fault;
mod grip;
mod hold;
mod least_squares;
mod object;
mod posture;
mod recorded;
mod set;
mod stage;
mod ways;

pub use definition::{Grasp, ObjectRange, Placement, StagePose};
pub use example::Example;
pub use fault::GraspFault;
pub(crate) use grip::grip;
pub(crate) use hold::hold;
pub use object::{Object, ObjectKind, PlacedObject};
pub use recorded::{PoseGroup, RecordedPose};
pub use set::{GraspSet, GraspSetError};
pub use stage::{Stage, UnknownStage};
pub use ways::{alike_grasps, presented_grasps};
