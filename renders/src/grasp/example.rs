//! How one hand was seen in a grasp: all its joint angles, and the object in its place.
//!
//! Fingers that close on an object by themselves touch it everywhere and alike; people's hands do
//! not. A scene can be posed like an example instead.

use nalgebra::Vector3;
use serde::Deserialize;

use super::fault::GraspFault;
use super::object::{Object, ObjectKind, PlacedObject};
use super::posture::{RawPose, unit};
use super::stage::Stage;
use crate::hand::HandPose;

/// One hand in one grasp at one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// How far the grasp is closed.
    pub stage: Stage,
    /// The joint angles.
    pub pose: HandPose,
    /// What is held or reached for, in the frame of a hand of mean size.
    pub object: PlacedObject,
}

/// An example as the file says it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawExample {
    stage: String,
    thumb: [f64; 5],
    index: [f64; 4],
    middle: [f64; 4],
    ring: [f64; 4],
    little: [f64; 4],
    object: RawBody,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBody {
    radius: f64,
    length: Option<f64>,
    axis: Option<[f64; 3]>,
    centre: [f64; 3],
}

impl RawExample {
    /// The example, if its angles are a hand's and its object is of this kind.
    pub(super) fn check(&self, kind: ObjectKind) -> Result<Example, GraspFault> {
        let stage: Stage = self.stage.parse()?;
        let pose = RawPose {
            thumb: self.thumb,
            index: self.index,
            middle: self.middle,
            ring: self.ring,
            little: self.little,
        };
        let pose = pose.check(&format!("example at {stage}"))?;
        Ok(Example { stage, pose, object: self.object.check(kind)? })
    }
}

impl RawBody {
    fn check(&self, kind: ObjectKind) -> Result<PlacedObject, GraspFault> {
        let size = |what: &'static str, metres: f64| {
            let fits = (0.001..=0.5).contains(&metres);
            fits.then_some(metres).ok_or(GraspFault::ExampleSize { what, metres })
        };
        if !self.centre.iter().all(|x| (-0.5..=0.5).contains(x)) {
            return Err(GraspFault::ExampleCentre);
        }
        let radius = size("radius", self.radius)?;
        let (object, axis) = match (kind, self.length, self.axis) {
            (ObjectKind::Sphere, None, None) => (Object::Sphere { radius }, Vector3::z()),
            (ObjectKind::Sphere, ..) => return Err(GraspFault::ExampleSphere),
            (_, Some(length), Some(axis)) => {
                (Object::Cylinder { radius, length: size("length", length)? }, unit("axis", axis)?)
            }
            _ => return Err(GraspFault::ExampleObject),
        };
        Ok(PlacedObject::new(object, self.centre.into(), &axis))
    }
}
