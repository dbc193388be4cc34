//! Where the camera stands, and where it saw the hand.

use std::path::Path;

use nalgebra::{Isometry3, Point3};
use serde::Deserialize;

use super::read::{Source, text};
use super::{DescriptionFault, RobotError};

/// A camera in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The pose of the optical frame (z forward, x right, y down) in the world (z up).
    pub world_from_camera: Isometry3<f64>,
    /// The wrist's centre in the camera's frame, in metres, where it is known.
    pub hand: Option<Point3<f64>>,
    /// The standard deviation of that position, in metres, where it is known.
    pub position_spread: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
    hand: Option<[f64; 3]>,
    position_spread: Option<f64>,
}

impl Camera {
    /// Reads `position` and `quaternion_xyzw`, and where they are known `hand` and
    /// `position_spread`.
    ///
    /// # Errors
    /// [`RobotError::Read`], [`RobotError::Format`].
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        Self::parse(&path.display().to_string(), &text(path)?)
    }

    /// Reads a description from memory; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Format`]: the pose is no rotation, the hand is behind the camera, a key is
    /// unknown.
    pub fn parse(name: &str, text: &str) -> Result<Self, RobotError> {
        let source = Source { name, what: "a camera" };
        let file: File = source.parse(text)?;
        if let Some(hand) = file.hand {
            source.position("hand", hand)?;
            let [.., ahead] = hand;
            if ahead <= 0.0 {
                return Err(source.error(DescriptionFault::HandBehind { ahead }));
            }
        }
        if let Some(spread) = file.position_spread {
            source.length("position_spread", spread, 1.0)?;
        }
        Ok(Self {
            world_from_camera: source.pose(file.position, file.quaternion_xyzw)?,
            hand: file.hand.map(Point3::from),
            position_spread: file.position_spread,
        })
    }
}
