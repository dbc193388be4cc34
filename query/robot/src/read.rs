//! Reading the TOML files of this part, with one form of error for all of them.

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::de::DeserializeOwned;

use super::{DescriptionFault, RobotError};

/// How far a quaternion's length may be from 1: five written decimals are exact enough, a typing
/// error is not.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Nothing that this program is for lies farther away, in metres.
const FAR: f64 = 100.0;
/// The longest description in bytes, thirty times as long as the longest of the built-in ones: what
/// the parser makes of a text takes many times as much memory.
const LONGEST: usize = 256 << 10;

/// A description's name and what it should describe, for its errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) what: &'static str,
}

impl Source<'_> {
    pub(super) fn error(self, fault: DescriptionFault) -> RobotError {
        RobotError::Format { name: self.name.to_owned(), what: self.what, fault: Box::new(fault) }
    }

    pub(super) fn parse<T: DeserializeOwned>(self, text: &str) -> Result<T, RobotError> {
        if text.len() > LONGEST {
            return Err(self.error(DescriptionFault::Long { kib: text.len() >> 10, most: LONGEST >> 10 }));
        }
        toml::from_str(text).map_err(|error| self.error(DescriptionFault::Toml(error)))
    }

    /// A rigid motion of checked parts.
    pub(super) fn pose(self, position: [f64; 3], xyzw: [f64; 4]) -> Result<Isometry3<f64>, RobotError> {
        self.position("position", position)?;
        let rotation = self.rotation("quaternion_xyzw", xyzw)?;
        Ok(Isometry3::from_parts(Translation3::from(position), rotation))
    }

    /// A rotation of a checked quaternion.
    pub(super) fn rotation(
        self,
        key: &'static str,
        xyzw: [f64; 4],
    ) -> Result<UnitQuaternion<f64>, RobotError> {
        let [x, y, z, w] = xyzw;
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        if length.is_nan() || (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(self.error(DescriptionFault::Rotation { key, length }));
        }
        Ok(UnitQuaternion::new_normalize(quaternion))
    }

    pub(super) fn position(self, key: &'static str, position: [f64; 3]) -> Result<(), RobotError> {
        if position.iter().any(|value| value.is_nan() || value.abs() > FAR) {
            return Err(self.error(DescriptionFault::Position { key, position, most: FAR }));
        }
        Ok(())
    }

    /// A length in metres, above 0.
    pub(super) fn length(self, key: &str, value: f64, most: f64) -> Result<f64, RobotError> {
        if !(value > 0.0 && value <= most) {
            return Err(self.error(DescriptionFault::Measure { key: key.to_owned(), value, most }));
        }
        Ok(value)
    }
}

/// The file that a name is, where it is one.
pub fn described(name: &str) -> Option<&Path> {
    Some(Path::new(name)).filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
}

/// The description of that name among those that come with the program.
pub(super) fn built_in(all: &[(&str, &'static str)], name: &str) -> Option<&'static str> {
    all.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The text of a file.
pub(super) fn text(path: &Path) -> Result<String, RobotError> {
    grasp_bounded::read_text(path).map_err(|cause| RobotError::Read { path: path.to_owned(), cause })
}
