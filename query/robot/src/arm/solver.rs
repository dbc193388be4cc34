//! Which postures of an arm bring its flange where it should be.

use std::f64::consts::TAU;

use nalgebra::Isometry3;

use super::numeric::Limbs;
use super::opw::Geometry;

/// How an arm's postures are found.
#[derive(Clone, Debug)]
pub(super) enum Solver {
    /// Analytically.
    Opw(Geometry),
    /// By going there step by step.
    Numeric(Limbs),
}

impl Solver {
    /// Postures that bring the flange there, in the base's frame: one of each sort. Some may be
    /// beyond the joints' limits; all are, where the limits are what is in the way.
    pub(super) fn postures(&self, flange: &Isometry3<f64>) -> Vec<Vec<f64>> {
        match self {
            Self::Opw(geometry) => geometry.postures(flange),
            Self::Numeric(limbs) => limbs.postures(flange),
        }
    }

    /// The same near the posture `last`.
    pub(super) fn near(&self, flange: &Isometry3<f64>, last: &[f64]) -> Vec<Vec<f64>> {
        match self {
            Self::Opw(geometry) => geometry.near(flange, last),
            Self::Numeric(limbs) => limbs.near(flange, last).into_iter().collect(),
        }
    }

    /// By how much a joint moves until the arm is as before; `None` of one that slides.
    pub(super) fn whole_turn(&self, joint: usize) -> Option<f64> {
        match self {
            Self::Opw(_) => Some(TAU),
            Self::Numeric(limbs) => limbs.whole_turn(joint),
        }
    }
}
