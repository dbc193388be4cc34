//! Reading the TOML files of this part, with one form of error for all of them.

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::de::DeserializeOwned;

use super::RobotError;

/// How far a quaternion's length may be from 1: five written decimals are exact enough, a typing
/// error is not.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Nothing that this program is for lies farther away, in metres.
const FAR: f64 = 100.0;

/// A description's name and what it should describe, for its errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) what: &'static str,
}

impl Source<'_> {
    pub(super) fn error(self, problem: impl Into<String>) -> RobotError {
        RobotError::Format { name: self.name.to_owned(), what: self.what, problem: problem.into() }
    }

    pub(super) fn parse<T: DeserializeOwned>(self, text: &str) -> Result<T, RobotError> {
        toml::from_str(text).map_err(|error| self.error(error.to_string().trim_end()))
    }

    /// A rigid motion of checked parts.
    pub(super) fn pose(self, position: [f64; 3], xyzw: [f64; 4]) -> Result<Isometry3<f64>, RobotError> {
        self.position("position", position)?;
        let [x, y, z, w] = xyzw;
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        if length.is_nan() || (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(self.error(format!(
                "quaternion_xyzw has the length {length:.4}: a rotation needs 1, in the order x, y, z, w"
            )));
        }
        Ok(Isometry3::from_parts(Translation3::from(position), UnitQuaternion::new_normalize(quaternion)))
    }

    pub(super) fn position(self, key: &str, position: [f64; 3]) -> Result<(), RobotError> {
        if position.iter().any(|value| value.is_nan() || value.abs() > FAR) {
            return Err(self.error(format!("{key} = {position:?}: each must be within {FAR} m")));
        }
        Ok(())
    }

    /// A length in metres, above 0.
    pub(super) fn length(self, key: &str, value: f64, most: f64) -> Result<f64, RobotError> {
        if !(value > 0.0 && value <= most) {
            return Err(self.error(format!("{key} = {value}: it must be above 0 and at most {most}")));
        }
        Ok(value)
    }
}

/// The file that a name is, where it is one.
pub fn described(name: &str) -> Option<&Path> {
    Some(Path::new(name)).filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
}

/// The description of that name among those that come with the program, or what names there are.
pub(super) fn built_in(all: &[(&str, &'static str)], name: &str) -> Result<&'static str, String> {
    let found = all.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    found.ok_or_else(|| all.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", "))
}

/// The text of a file.
pub(super) fn text(path: &Path) -> Result<String, RobotError> {
    std::fs::read_to_string(path).map_err(|cause| RobotError::Read { path: path.to_owned(), cause })
}
