//! The object: a simple shape, where it lies, and what it weighs.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::Deserialize;

use super::read::{Source, text};
use super::{Camera, DescriptionFault, RobotError};

/// How deep an object may lie in its table before that is an error, in metres: what a measurement
/// may be wrong by.
const SUNK: f64 = 0.002;
/// The largest object, from one side to the other, in metres.
pub(super) const LARGEST: f64 = 2.0;

/// A convex shape about its own middle, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A cylinder or a disc; its axis is z.
    Cylinder {
        /// Of the circle.
        radius: f64,
        /// From end to end.
        height: f64,
    },
    /// A box.
    Box {
        /// Whole lengths along x, y and z.
        size: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Of the ball.
        radius: f64,
    },
}

impl Shape {
    /// How far the shape reaches from its middle in a direction of unit length, in metres.
    pub fn reach(&self, direction: &Vector3<f64>) -> f64 {
        match self {
            Self::Cylinder { radius, height } => {
                radius * direction.xy().norm() + 0.5 * height * direction.z.abs()
            }
            Self::Box { size } => 0.5 * direction.abs().dot(&Vector3::from(*size)),
            Self::Sphere { radius } => *radius,
        }
    }

    /// How far a point in the shape's frame is from its surface, in metres; 0 inside.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        match self {
            Self::Cylinder { radius, height } => {
                let beside = (point.coords.xy().norm() - radius).max(0.0);
                beside.hypot((point.z.abs() - 0.5 * height).max(0.0))
            }
            Self::Box { size } => {
                let beyond = point.coords.abs() - 0.5 * Vector3::from(*size);
                beyond.map(|metres| metres.max(0.0)).norm()
            }
            Self::Sphere { radius } => (point.coords.norm() - radius).max(0.0),
        }
    }

    /// How far a point in the shape's frame is inside its surface, in metres; 0 outside.
    pub fn depth(&self, point: &Point3<f64>) -> f64 {
        let depth = match self {
            Self::Cylinder { radius, height } => {
                (radius - point.coords.xy().norm()).min(0.5 * height - point.z.abs())
            }
            Self::Box { size } => (0.5 * Vector3::from(*size) - point.coords.abs()).min(),
            Self::Sphere { radius } => radius - point.coords.norm(),
        };
        depth.max(0.0)
    }

    /// The way from the middle to the surface in a direction of unit length, in metres.
    pub fn half_chord(&self, direction: &Vector3<f64>) -> f64 {
        // A direction along a face never meets it.
        match self {
            Self::Cylinder { radius, height } => {
                (radius / direction.xy().norm()).min(0.5 * height / direction.z.abs())
            }
            Self::Box { size } => {
                let [x, y, z] = size.map(|length| 0.5 * length);
                (x / direction.x.abs()).min(y / direction.y.abs()).min(z / direction.z.abs())
            }
            Self::Sphere { radius } => *radius,
        }
    }
}

/// A thing to be grasped.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What messages and records call it.
    pub name: String,
    /// What it looks like.
    pub shape: Shape,
    /// In kilograms.
    pub mass: f64,
    /// Of the object against fingers.
    pub friction: f64,
    /// The frame that `pose` is in.
    pub frame: Frame,
    /// `frame_from_object`, about the shape's middle.
    pub pose: Isometry3<f64>,
    /// The height of the table in the world, in metres, where there is one.
    pub table: Option<f64>,
}

/// What a pose is relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// z up.
    #[default]
    World,
    /// The camera's optical frame.
    Camera,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Option<String>,
    shape: String,
    radius: Option<f64>,
    height: Option<f64>,
    size: Option<[f64; 3]>,
    mass: Option<f64>,
    friction: Option<f64>,
    #[serde(default)]
    frame: Frame,
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
    table: Option<f64>,
}

impl Object {
    /// Reads a description: `name`, `shape` (`cylinder` or `disc` with `radius`
    /// and `height`, `box` with `size`, `sphere` with `radius`), `position`, `quaternion_xyzw`, and
    /// where they matter `frame`, `mass`, `friction`, `table`.
    ///
    /// # Errors
    /// [`RobotError::Read`], [`RobotError::Format`].
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        Self::parse(&path.display().to_string(), &text(path)?)
    }

    /// Reads a description from memory; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Format`]: a size is missing, impossible or that of another shape, the pose is
    /// no rotation, a key is unknown.
    pub fn parse(name: &str, text: &str) -> Result<Self, RobotError> {
        let source = Source { name, what: "an object" };
        let file: File = source.parse(text)?;
        let needed = |key: &'static str, value: Option<f64>, most: f64| {
            let missing = || DescriptionFault::MissingMeasure { shape: file.shape.clone(), key };
            source.length(key, value.ok_or_else(|| source.error(missing()))?, most)
        };
        let radius = || needed("radius", file.radius, 0.5 * LARGEST);
        let none_of = |others: &[(&'static str, bool)]| match others.iter().find(|(_, is_there)| *is_there) {
            Some((key, _)) => {
                Err(source.error(DescriptionFault::NeedlessMeasure { shape: file.shape.clone(), key }))
            }
            None => Ok(()),
        };
        let [has_radius, has_height] = [file.radius, file.height].map(|measure| measure.is_some());
        let shape = match file.shape.as_str() {
            "cylinder" | "disc" => {
                none_of(&[("size", file.size.is_some())])?;
                Shape::Cylinder { radius: radius()?, height: needed("height", file.height, LARGEST)? }
            }
            "sphere" => {
                none_of(&[("size", file.size.is_some()), ("height", has_height)])?;
                Shape::Sphere { radius: radius()? }
            }
            "box" => {
                none_of(&[("radius", has_radius), ("height", has_height)])?;
                let size = file.size.ok_or_else(|| source.error(DescriptionFault::MissingSize))?;
                for length in size {
                    source.length("size", length, LARGEST)?;
                }
                Shape::Box { size }
            }
            other => return Err(source.error(DescriptionFault::Shape(other.to_owned()))),
        };
        if let Some(table) = file.table {
            source.position("table", [0.0, 0.0, table])?;
        }
        let mass = file.mass.map_or(Ok(DEFAULT_MASS), |mass| source.length("mass", mass, 50.0))?;
        let friction = file.friction.map_or(Ok(DEFAULT_FRICTION), |mu| source.length("friction", mu, 5.0))?;
        Ok(Self {
            name: file.name.unwrap_or_else(|| "object".into()),
            shape,
            mass,
            friction,
            frame: file.frame,
            pose: source.pose(file.position, file.quaternion_xyzw)?,
            table: file.table,
        })
    }

    /// `world_from_object`.
    ///
    /// # Errors
    /// [`RobotError::Format`]: the object lies in its table.
    pub fn in_world(&self, camera: &Camera) -> Result<Isometry3<f64>, RobotError> {
        let world_from_object = match self.frame {
            Frame::World => self.pose,
            Frame::Camera => camera.world_from_camera * self.pose,
        };
        self.checked(world_from_object)
    }

    /// `world_from_object` of an object that the camera sees: one that lies behind it cannot be
    /// what the hand in its picture holds.
    ///
    /// # Errors
    /// As [`Self::in_world`]; [`RobotError::BehindCamera`].
    pub(super) fn seen_by(&self, camera: &Camera) -> Result<Isometry3<f64>, RobotError> {
        let world_from_object = self.in_world(camera)?;
        let middle = world_from_object.translation.vector.into();
        let ahead = camera.world_from_camera.inverse_transform_point(&middle).z;
        if ahead <= 0.0 {
            return Err(RobotError::BehindCamera { object: self.name.clone(), ahead });
        }
        Ok(world_from_object)
    }

    /// `world_from_object`, which does not lie in the table.
    pub(super) fn checked(&self, world_from_object: Isometry3<f64>) -> Result<Isometry3<f64>, RobotError> {
        let down = world_from_object.inverse_transform_vector(&-Vector3::z());
        let lowest = world_from_object.translation.z - self.shape.reach(&down);
        if let Some(metres) = self.table.map(|table| table - lowest).filter(|depth| *depth > SUNK) {
            let source = Source { name: &self.name, what: "an object on a table" };
            return Err(source.error(DescriptionFault::InTable { metres }));
        }
        Ok(world_from_object)
    }
}

/// What an object weighs that does not say, in kilograms.
const DEFAULT_MASS: f64 = 0.35;
/// Rubber on plastic.
const DEFAULT_FRICTION: f64 = 0.8;
