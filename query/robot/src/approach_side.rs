//! From where a hand comes to an object on a table.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// From where the hand comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = From))]
#[serde(rename_all = "lowercase")]
pub enum ApproachSide {
    /// From above; the palm's x is the world's, the fingers close along y.
    Top,
    /// Along the world's x; the fingers close along y.
    Side,
}

impl ApproachSide {
    /// How a palm that comes from there is turned in the world.
    pub fn turned(self) -> UnitQuaternion<f64> {
        let (x, z) = match self {
            Self::Top => (Vector3::x(), -Vector3::z()),
            Self::Side => (Vector3::z(), Vector3::x()),
        };
        let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
    }

    /// From where a hand comes that moves along `approach`, of unit length in the world: the nearer
    /// of both, `None` where it comes from below.
    pub fn nearest(approach: &Vector3<f64>) -> Option<Self> {
        match -approach.z {
            down if down > FRAC_1_SQRT_2 => Some(Self::Top),
            down if down > -FRAC_1_SQRT_2 => Some(Self::Side),
            _ => None,
        }
    }

    /// In a sentence.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Top => "from above",
            Self::Side => "from the side",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_palm_that_comes_from_there_comes_from_there() {
        for from in [ApproachSide::Top, ApproachSide::Side] {
            assert_eq!(ApproachSide::nearest(&(from.turned() * Vector3::z())), Some(from));
        }
        assert_eq!(ApproachSide::nearest(&Vector3::z()), None);
        assert_eq!(ApproachSide::nearest(&Vector3::new(0.6, 0.0, -0.8)), Some(ApproachSide::Top));
        assert_eq!(ApproachSide::nearest(&Vector3::new(0.0, 0.8, 0.6)), Some(ApproachSide::Side));
    }
}
