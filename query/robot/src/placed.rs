//! Where the palm is when the fingers close, and the posture of the fingers.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::face::Face;
use super::hand::{RobotGrasp, RobotHand, Value};
use super::{Object, RobotError};

/// The palm's whole face stays so far from the object, in metres, where the grasp has its middle
/// farther away: about what the object's position may be wrong by. It is the wrap's standoff, with
/// which its windows were simulated.
const AIR: f64 = 0.010;

/// A palm that is where it closes.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) world_from_palm: Isometry3<f64>,
    /// The palm's z in the world.
    pub(super) approach: Vector3<f64>,
    /// The object's extent across the fingers, in metres.
    pub(super) width: f64,
}

impl Placed {
    /// Puts a palm that is turned so before the object, aimed at `grip`, as near as the grasp wants
    /// and both the table and the palm's whole face allow: where it is tilted, its rim comes to the
    /// object before its middle does.
    pub(super) fn new(
        hand: &RobotHand,
        grasp: &RobotGrasp,
        object: &Object,
        world_from_object: &Isometry3<f64>,
        turned: UnitQuaternion<f64>,
        grip: Point3<f64>,
    ) -> Result<Self, RobotError> {
        // Through the middle, where the fingers close: the extent of the whole would be that of its
        // far, tilted ends.
        let half = |direction: Vector3<f64>| {
            object.shape.half_chord(&world_from_object.inverse_transform_vector(&direction))
        };
        let approach = turned * Vector3::z();
        let width = 2.0 * half(turned * Vector3::y());
        if let Some(widest) = grasp.widest.filter(|widest| width > *widest) {
            let quarter = 2.0 * half(turned * Vector3::x());
            return Err(RobotError::TooWide {
                object: object.name.clone(),
                hand: hand.name.clone(),
                width,
                widest,
                turned: (quarter <= widest).then_some(quarter),
                others: Vec::new(),
            });
        }
        let middle = world_from_object.translation.vector;
        let standoff = grasp.standoff.at(width);
        let beside = grip - turned * Vector3::y() * grasp.middle.at(width);
        let face = Face { middle: beside, turned, radius: hand.palm_radius };
        let room = face.room(&object.shape, world_from_object) - standoff.min(AIR);
        let along = (middle - grip.coords).dot(&approach) - half(approach) - standoff;
        let mut palm = beside + approach * along.min(room);
        let down = -approach.z;
        if let Some(table) = object.table.filter(|_| down > 0.0) {
            let tilt = approach.xy().norm();
            let missing = table + grasp.table_clearance * down + grasp.table_reach * tilt - palm.z;
            if missing > 0.0 {
                palm -= approach * (missing / down);
            }
        }
        Ok(Self { world_from_palm: Isometry3::from_parts(palm.coords.into(), turned), approach, width })
    }
}

/// The joints' values for an object of this width, in metres.
pub(super) fn posture(joints: &BTreeMap<String, Value>, width: f64) -> BTreeMap<String, f64> {
    joints.iter().map(|(name, value)| (name.clone(), value.at(width))).collect()
}
