//! What a vote is counted from.

use nalgebra::UnitQuaternion;

/// A neighbour as the vote sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ballot {
    pub(crate) class: u16,
    pub(crate) distance: f64,
    /// `None` where the index keeps no orientations.
    pub(crate) orientation: Option<UnitQuaternion<f64>>,
}
