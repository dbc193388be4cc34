//! An arm as data: its joints, and where it stands.

use std::f64::consts::PI;

use nalgebra::Isometry3;
use serde::Deserialize;

use super::numeric::Limbs;
use super::opw::Geometry;
use super::solver::Solver;
use crate::chain::Segment;
use crate::read::{Source, built_in, described, text};
use crate::{DescriptionFault, RobotError};

/// The arms that come with the program.
const BUILT_IN: [(&str, &str); 3] = [
    ("franka-panda", include_str!("../../../data/arms/franka-panda.toml")),
    ("kuka-kr6-r700", include_str!("../../../data/arms/kuka-kr6-r700.toml")),
    ("ur5e", include_str!("../../../data/arms/ur5e.toml")),
];

/// The largest arm: whoever describes one to a service decides how long the service works on it.
const MOST_JOINTS: usize = 32;
const MOST_SEGMENTS: usize = 64;

/// An arm and where it stands: six axes of which the last three meet in a point, or any chain of
/// joints.
#[derive(Clone, Debug)]
pub struct Arm {
    pub(super) name: String,
    pub(super) joints: Vec<String>,
    pub(super) limits: Vec<[f64; 2]>,
    pub(super) solver: Solver,
    pub(super) base_from_world: Isometry3<f64>,
    pub(super) wrist_from_flange: Isometry3<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(rename = "about")]
    _about: Option<String>,
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
    joints: Vec<String>,
    limits: Vec<[f64; 2]>,
    geometry: Option<Geometry>,
    segment: Option<Vec<Segment>>,
    mount: Mount,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mount {
    position: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

impl Arm {
    /// The arm that comes with the program by that name, or that a file ending in `.toml`
    /// describes.
    ///
    /// # Errors
    /// [`RobotError::Read`], [`RobotError::Format`], [`RobotError::UnknownArm`].
    pub fn find(name: &str) -> Result<Self, RobotError> {
        match described(name) {
            Some(path) => Self::parse(name, &text(path)?),
            None => Self::built_in(name),
        }
    }

    /// The names of the arms that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// An arm that this program knows.
    ///
    /// # Errors
    /// [`RobotError::UnknownArm`].
    pub fn built_in(name: &str) -> Result<Self, RobotError> {
        let known = || Self::names().collect::<Vec<_>>().join(", ");
        let text = built_in(&BUILT_IN, name)
            .ok_or_else(|| RobotError::UnknownArm { name: name.to_owned(), known: known() })?;
        Self::parse(name, text)
    }

    /// Reads a description from memory; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Format`].
    pub fn parse(name: &str, text: &str) -> Result<Self, RobotError> {
        let source = Source { name, what: "an arm" };
        let file: File = source.parse(text)?;
        if file.joints.len() != file.limits.len() {
            let (joints, limits) = (file.joints.len(), file.limits.len());
            return Err(source.error(DescriptionFault::JointCount { joints, limits }));
        }
        let segments = file.segment.as_ref().map_or(0, Vec::len);
        if file.joints.len() > MOST_JOINTS || segments > MOST_SEGMENTS {
            return Err(source.error(DescriptionFault::ArmSize {
                joints: file.joints.len(),
                most_joints: MOST_JOINTS,
                segments,
                most_segments: MOST_SEGMENTS,
            }));
        }
        for (joint, [low, high]) in file.joints.iter().zip(&file.limits) {
            // Within two turns, as the solver asks of angles that it is to keep near.
            let most = 4.0 * PI;
            if !(low < high && *low >= -most && *high <= most) {
                let (joint, low, high) = (joint.clone(), *low, *high);
                return Err(source.error(DescriptionFault::Limits { joint, low, high }));
            }
        }
        let solver = match (file.geometry, file.segment) {
            (Some(geometry), None) => {
                if file.joints.len() != 6 {
                    return Err(source.error(DescriptionFault::SixJoints));
                }
                geometry.check(source)?;
                Solver::Opw(geometry)
            }
            (None, Some(segments)) => {
                Solver::Numeric(Limbs::new(source, segments, &file.joints, &file.limits)?)
            }
            (Some(_), Some(_)) | (None, None) => {
                return Err(source.error(DescriptionFault::NoJoints));
            }
        };
        let mount = Source { name, what: "an arm with its [mount]" };
        Ok(Self {
            base_from_world: source.pose(file.position, file.quaternion_xyzw)?.inverse(),
            wrist_from_flange: mount.pose(file.mount.position, file.mount.quaternion_xyzw)?.inverse(),
            name: file.name,
            joints: file.joints,
            limits: file.limits,
            solver,
        })
    }
}
