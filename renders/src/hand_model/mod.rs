//! A hand that somebody modelled or scanned: a skinned mesh in a binary glTF 2.0 file.
//!
//! The joints are those of the WebXR Hand Input specification. Their places in the rest pose, and
//! the skin around them, are measured; of that a [`HandShape`] and a skeleton are made, which
//! grasps, objects and examples treat like any other hand's. What is drawn is the model's own skin,
//! moved with the bones.

mod error;
mod fault;
mod few;
mod glb;
mod measure;
mod pose;
mod rig;
#[cfg(test)]
mod tests;

use std::fmt;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use grasp_canonical::{Canonical, Encoder};
use nalgebra::Vector3;
use xxhash_rust::xxh3::xxh3_64;

use crate::hand::{HandShape, Skeleton};
pub use error::HandModelError;
use error::LONGEST;
pub use fault::{ModelFault, NotAHand, Unsupported};
use glb::Glb;
use measure::RestPose;
use rig::{Rig, Skin};

/// Longest name, in bytes: it becomes part of file names.
const LONGEST_NAME: usize = 64;

/// A hand read from a file.
pub struct HandModel {
    shape: HandShape,
    rest: RestPose,
    skin: Skin,
    /// Hash of the file.
    hash: u64,
}

impl fmt::Debug for HandModel {
    /// What identifies it: the name and a hash of the file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "HandModel({} {:016x})", self.shape.name, self.hash)
    }
}

impl Canonical for HandModel {
    /// What identifies it: the name and a hash of the file.
    fn encode(&self, to: &mut Encoder) {
        to.text(&self.shape.name).u64(self.hash);
    }
}

impl PartialEq for HandModel {
    fn eq(&self, other: &HandModel) -> bool {
        (&self.shape.name, self.hash) == (&other.shape.name, other.hash)
    }
}

impl HandModel {
    /// Reads a `.glb` file; the hand is named after it.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is damaged, uses extensions or files beside it, lacks a joint,
    /// or shows no hand of human size (glTF is in metres).
    pub fn load(path: impl AsRef<Path>) -> Result<HandModel, HandModelError> {
        let path = path.as_ref();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut bytes = Vec::new();
        File::open(path)?.take(LONGEST + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > LONGEST {
            return Err(HandModelError::TooLarge);
        }
        HandModel::parse(&name, &bytes)
    }

    /// Reads the bytes of a `.glb` file.
    ///
    /// # Errors
    ///
    /// As [`HandModel::load`].
    pub fn parse(name: &str, bytes: &[u8]) -> Result<HandModel, HandModelError> {
        check_name(name)?;
        let rig = Rig::read(&Glb::parse(bytes)?)?;
        let (shape, rest, skin) = measure::measure(name, rig)?;
        Ok(HandModel { shape, rest, skin, hash: xxh3_64(bytes) })
    }

    /// The measures of the hand, named like the file.
    pub fn shape(&self) -> &HandShape {
        &self.shape
    }

    /// Whether the file shows a left hand, which is mirrored.
    pub fn was_left(&self) -> bool {
        self.rest.was_left
    }

    /// The hand's own skeleton.
    pub(crate) fn skeleton(&self) -> Skeleton {
        Skeleton::with_roots(&self.shape, self.rest.roots())
    }

    /// The middle of the place where the hand is cut when it is to have `forearm` metres behind the
    /// wrist: there, or where the model ends.
    pub(crate) fn cut(&self, forearm: f64) -> Vector3<f64> {
        let wanted = -(crate::hand::WRIST_CUT + forearm.max(0.0));
        let [y, z] = self.rest.wrist;
        Vector3::new(wanted.max(self.rest.end), y, z)
    }
}

fn check_name(name: &str) -> Result<(), HandModelError> {
    let fit = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let fits = !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(fit);
    if !fits || HandShape::preset(name).is_ok() {
        return Err(HandModelError::Name(name.to_owned()));
    }
    Ok(())
}
