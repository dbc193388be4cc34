//! The arm that carries the hand: joint angles along a strategy's way, or why there are none.

mod carry;
mod described;
mod motion;
mod numeric;
mod opw;
mod solver;

pub use described::Arm;
pub use motion::{ArmMotion, Hindrance, Unreachable, Waypoint};
