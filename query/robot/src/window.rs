//! What error a grasp tolerated in simulation.

use serde::{Deserialize, Serialize};

use super::ApproachSide;

/// An error that is tolerated. In a grasp's description, by what was simulated; in a strategy, what
/// the strategy's own attitude leaves of that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// The object's place on the table may be wrong by as much as this in either direction, in
    /// metres.
    pub position_m: f64,
    /// The hand's turn about the vertical may be wrong by as much as this in either direction, in
    /// radians; none where that was not simulated.
    pub yaw_rad: Option<f64>,
    /// The approach may be tilted by as much as this in any direction, in radians; none where that
    /// was not simulated.
    pub tilt_rad: Option<f64>,
    /// Where the hand comes from the side: it may be turned about its approach by as much as this
    /// in either direction, in radians; none where that was not simulated. From above that is a
    /// yaw.
    pub roll_rad: Option<f64>,
    /// What one link pressed with, at most, where object and hand were where they should be, in
    /// newtons; none where that was not measured.
    pub force_n: Option<f64>,
    /// The object that this was simulated with.
    pub object: String,
    /// That object's extent across the closing fingers, in metres.
    pub width_m: f64,
    /// From where the hand came to it.
    pub from: ApproachSide,
    /// Along which axis of the palm that object's own lay; without it, it is of no account.
    pub axis: Option<LiesAlong>,
    /// What simulated it.
    pub engine: String,
}

/// Along which axis of the palm an object's own axis lay: a cylinder's, or a box's longest side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
pub enum LiesAlong {
    /// The palm's x: the fingers close across it.
    X,
    /// The palm's z, the approach: the fingers close around it.
    Z,
    /// It had none: a ball.
    None,
}
