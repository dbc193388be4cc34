//! The motion of an arm as data: waypoints, or where and why it stops.

use serde::Serialize;

/// What the arm does while the hand approaches and retreats. JSON keys are an interface: they may
/// be added to, never renamed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ArmMotion {
    /// The arm.
    pub arm: String,
    /// Its joints, in the order of the waypoints' angles.
    pub joint_names: Vec<String>,
    /// Whether it can carry the hand all the way.
    pub reachable: bool,
    /// The way in joint angles, at most 10 mm apart; none where it is unreachable.
    pub waypoints: Vec<Waypoint>,
    /// Where the way ends, for an arm that cannot go on.
    pub unreachable: Option<Unreachable>,
}

/// A point of the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Waypoint {
    /// `approach` or `retreat`.
    pub step: &'static str,
    /// How far along that step's way, in metres.
    pub distance: f64,
    /// The joints' angles in radians (metres for a sliding one).
    pub joints: Vec<f64>,
}

/// Where an arm cannot go on, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Unreachable {
    /// `approach` or `retreat`.
    pub step: &'static str,
    /// How far along that step's way, in metres.
    pub distance: f64,
    /// What keeps it.
    pub why: Hindrance,
}

/// What keeps an arm from a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Hindrance {
    /// The pose is too far away, or too near.
    OutOfReach,
    /// A joint would have to turn beyond its limits.
    JointLimit,
    /// A joint would have to jump through a large angle, where the wrist is stretched.
    Leap,
}

impl std::fmt::Display for Hindrance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OutOfReach => "it is out of reach",
            Self::JointLimit => "a joint's limit is in the way",
            Self::Leap => "a joint would have to turn over on the way",
        })
    }
}
