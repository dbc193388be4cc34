//! What a grasp is: its objects, where they sit, and how the hand closes.

use nalgebra::Vector3;
use serde::Deserialize;

use super::example::Example;
use super::object::{Object, ObjectKind};
use super::stage::Stage;
use crate::hand::{Digit, HandPose};

/// Where an object sits in the hand.
#[derive(Debug, Clone, PartialEq)]
pub enum Placement {
    /// Pushed against the palm.
    Palm {
        /// The point of the palm that it is pushed toward: shares of the palm's length and breadth.
        anchor: [f64; 2],
        /// The direction out of the hand from which it comes, in the hand frame (unit length).
        push: Vector3<f64>,
    },
    /// Held between the tips of the thumb and these fingers.
    Tips {
        /// The fingers opposite to the thumb.
        between: Vec<Digit>,
    },
}

/// The objects that a grasp is used for.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectRange {
    /// Kind.
    pub kind: ObjectKind,
    /// Smallest and largest radius in metres.
    pub radius: [f64; 2],
    /// Shortest and longest length in metres; 0 for a sphere.
    pub length: [f64; 2],
    /// The axis in the hand frame (unit length).
    pub axis: Vector3<f64>,
    /// Where it sits.
    pub placement: Placement,
}

impl ObjectRange {
    /// The object a share `size` (0 to 1) of the way from the smallest to the largest.
    pub fn object(&self, size: f64) -> Object {
        let between = |[low, high]: [f64; 2]| low + (high - low) * size.clamp(0.0, 1.0);
        match self.kind {
            ObjectKind::Sphere => Object::Sphere { radius: between(self.radius) },
            ObjectKind::Cylinder | ObjectKind::Disc => {
                Object::Cylinder { radius: between(self.radius), length: between(self.length) }
            }
        }
    }
}

/// How far the fingers have gone at a stage.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StagePose {
    /// Share of the way from the relaxed hand to the grasp, 0 to 1.
    pub closure: f64,
    /// How far the object is still away, in metres.
    pub away: f64,
}

/// One grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct Grasp {
    /// Its name, as in labels and file names.
    pub name: String,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// What it is, in words.
    pub about: String,
    /// The direction of the hand frame that points up in the world (unit length).
    pub up: Vector3<f64>,
    /// The digits that must reach the object.
    pub touch: Vec<Digit>,
    /// The digits that do as their neighbour on the thumb's side does when they miss the object.
    pub follow: Vec<Digit>,
    /// What it holds.
    pub object: ObjectRange,
    /// The hand on its way to any grasp.
    pub relaxed: HandPose,
    /// The hand before it closes.
    pub open: HandPose,
    /// Where the digits would end with nothing in their way.
    pub closed: HandPose,
    /// The stages `reach` and `close`.
    pub(crate) stages: [StagePose; 2],
    /// Hands of this grasp as they were seen; may be none.
    pub examples: Vec<Example>,
}

impl Grasp {
    /// How far the fingers have gone at a stage; at [`Stage::Grasp`] all the way.
    pub fn stage(&self, stage: Stage) -> StagePose {
        match stage {
            Stage::Reach => self.stages[0],
            Stage::Close => self.stages[1],
            Stage::Grasp => StagePose { closure: 1.0, away: 0.0 },
        }
    }
}
