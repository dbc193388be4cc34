//! The sequence that a robot carries out.

use std::collections::BTreeMap;

use serde::Serialize;

use super::pose::{Direction, Pose};

/// A part of the sequence.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(tag = "step", rename_all = "lowercase")]
pub enum Step {
    /// The fingers are brought into the open posture, away from the object.
    Preshape {
        /// Every joint's value.
        joints: BTreeMap<String, f64>,
    },
    /// The hand moves straight to the object.
    Approach {
        /// Where the wrist starts.
        from: Pose,
        /// Where it ends.
        to: Pose,
        /// The way's direction.
        direction: Direction,
        /// The way's length.
        distance: f64,
        /// The least length that will do.
        min_distance: f64,
    },
    /// The fingers close until they meet the object.
    Grasp {
        /// What they aim at.
        joints: BTreeMap<String, f64>,
        /// What they may press with, by the hand's description.
        max_contact_force: f64,
        /// What one link pressed with in the simulation of such an object, at most; null where that
        /// is unknown.
        simulated_force: Option<f64>,
    },
    /// The hand lifts the object.
    Retreat {
        /// The way's direction.
        direction: Direction,
        /// The way's length.
        distance: f64,
        /// The least length that will do.
        min_distance: f64,
    },
}
