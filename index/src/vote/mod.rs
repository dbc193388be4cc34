//! From neighbours to an answer: the class (Equation 3), the orientation (Equation 4), and the width sigma of the
//! kernel that both weigh with (Equation 5).

mod class;
mod orientation;
mod sigma;

pub(crate) use class::{kernel_mass, probabilities};
pub(crate) use orientation::estimate;
pub use orientation::{OrientationEstimate, cyclic_euler_mean, mean_rotation};
pub(crate) use sigma::measure as measure_sigma;
pub use sigma::{Sigma, mean_distance};

/// How neighbours are weighed. The default is what the index was calibrated with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoteOptions {
    /// The kernel's width, in units of descriptor distance, in place of the index's own.
    pub sigma: Option<f64>,
    /// A factor on sigma, in place of the index's own calibrated one.
    pub sigma_scale: Option<f64>,
    /// Take Equation 5 as it is printed, which makes every weight all but 1, in place of its words. Both other widths
    /// take precedence.
    pub literal_sigma: bool,
    /// Take Equation 4 literally, as a cyclic mean of each Euler angle by itself, in place of the mean rotation.
    pub euler_mean: bool,
}

/// The answer of the neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct Vote {
    /// Every class of the index, most probable first; equals by class number.
    pub classes: Vec<ClassScore>,
    /// The sum of Equation 3's weights over all neighbours, from 0 (nothing alike in the index) to the number of neighbours.
    pub kernel_mass: f64,
    /// The orientation, from the neighbours of the first class alone.
    pub orientation: OrientationEstimate,
}

/// One class and its share of the vote.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassScore {
    /// The class's number in the index.
    pub class: u16,
    /// Its name.
    pub name: String,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// Equation 3's sum for the class, divided by that of all classes: 0 to 1.
    pub probability: f64,
}

/// A neighbour as the vote sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ballot {
    pub(crate) class: u16,
    pub(crate) distance: f64,
    /// `None` where the index keeps no orientations.
    pub(crate) orientation: Option<nalgebra::UnitQuaternion<f64>>,
}
