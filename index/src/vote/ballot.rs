//! What a vote is counted from.

use crate::rotation::turned_orientation;
use nalgebra::UnitQuaternion;

/// A neighbour as the vote sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ballot {
    pub(crate) class: u16,
    pub(crate) distance: f64,
    /// `None` where the index keeps no orientations.
    pub(crate) orientation: Option<UnitQuaternion<f64>>,
}

impl Ballot {
    /// The same for the picture turned clockwise by `turn_deg`.
    pub(crate) fn turned(self, turn_deg: f64) -> Self {
        if turn_deg == 0.0 {
            return self;
        }
        let orientation = self.orientation.map(|orientation| turned_orientation(turn_deg, &orientation));
        Self { orientation, ..self }
    }
}
