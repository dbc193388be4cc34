//! Arms of six axes of which the last three meet in a point: solved analytically.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, UnitQuaternion};
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Joints, Kinematics as _, Pose as FlangePose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use serde::Deserialize;

use crate::read::Source;
use crate::{DescriptionFault, RobotError};

/// No arm on a table is longer, in metres.
const LONGEST: f64 = 10.0;

/// Lengths in metres, angles in radians (Brandstoetter, Angerer, Hofbaur 2014, Figure 1).
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Geometry {
    a1: f64,
    a2: f64,
    b: f64,
    c1: f64,
    c2: f64,
    c3: f64,
    c4: f64,
    offsets: [f64; 6],
    signs: [i8; 6],
}

impl Geometry {
    /// All postures that bring the flange there, whatever the joints' limits.
    pub(super) fn postures(&self, flange: &Isometry3<f64>) -> Vec<Vec<f64>> {
        let solver = OPWKinematics::new(self.parameters());
        // Nothing reaches a pose of numbers that are none.
        let found = pose(flange).map(|flange| solver.inverse(&flange)).unwrap_or_default();
        found.iter().map(|joints| joints.to_vec()).collect()
    }

    /// The same, each with the turns of its joints that are nearest to `last`.
    pub(super) fn near(&self, flange: &Isometry3<f64>, last: &[f64]) -> Vec<Vec<f64>> {
        let Ok(last) = Joints::try_from(last) else { return Vec::new() };
        let solver = OPWKinematics::new(self.parameters());
        let found = pose(flange).map(|flange| solver.inverse_continuing(&flange, &last)).unwrap_or_default();
        found.iter().map(|joints| joints.to_vec()).collect()
    }

    pub(super) fn check(&self, source: Source<'_>) -> Result<(), RobotError> {
        let lengths = [
            ("a1", self.a1),
            ("a2", self.a2),
            ("b", self.b),
            ("c1", self.c1),
            ("c2", self.c2),
            ("c3", self.c3),
            ("c4", self.c4),
        ];
        for (key, metres) in lengths {
            if metres.is_nan() || metres.abs() > LONGEST {
                return Err(source.error(DescriptionFault::Dimension { key, metres, most: LONGEST }));
            }
        }
        source.length("c2, the upper arm,", self.c2, LONGEST)?;
        source.length("c3, the lower arm,", self.c3, LONGEST)?;
        if let Some(offset) = self.offsets.iter().find(|offset| offset.is_nan() || offset.abs() > TAU) {
            return Err(source.error(DescriptionFault::Offset(*offset)));
        }
        if self.signs.iter().any(|sign| sign.abs() != 1) {
            return Err(source.error(DescriptionFault::Signs(self.signs)));
        }
        Ok(())
    }

    fn parameters(&self) -> Parameters {
        let Self { a1, a2, b, c1, c2, c3, c4, offsets, signs } = *self;
        Parameters { a1, a2, b, c1, c2, c3, c4, offsets, sign_corrections: signs, dof: 6 }
    }
}

/// The same in the solver's types; `None` where a number is not finite.
fn pose(isometry: &Isometry3<f64>) -> Option<FlangePose> {
    let rotation: &UnitQuaternion<f64> = &isometry.rotation;
    let at = isometry.translation.vector;
    let rotation = DQuat::from_xyzw(rotation.i, rotation.j, rotation.k, rotation.w);
    FlangePose::try_from_parts(DVec3::new(at.x, at.y, at.z), rotation).ok()
}
