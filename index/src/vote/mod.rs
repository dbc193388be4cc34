//! From neighbours to an answer: the class (Equation 3), the orientation (Equation 4), and the
//! width sigma of the kernel that both weigh with (Equation 5). What the class's share of the
//! weights is worth as a probability is fitted on hands that the index does not hold. Opinions of
//! the network that made the descriptor join both (`joined`, `orientation`).

mod ballot;
mod calibration;
mod class;
mod fit;
mod joined;
mod orientation;
mod reliability;
mod sigma;

pub(crate) use ballot::Ballot;
pub use calibration::{Calibrated, Calibration, Doubt};
pub(crate) use class::{kernel_mass, shares};
pub(crate) use fit::{Example, MOST_VOTERS, calibrate, noise_of_the_farthest, noise_of_the_vote};
pub(crate) use joined::Joined;
pub(crate) use orientation::estimate;
pub use orientation::{OrientationEstimate, mean_rotation};
pub use reliability::{Reliability, ReliabilityBin};
pub(crate) use sigma::measure as measure_sigma;
pub use sigma::{Sigma, mean_distance};

use crate::descriptor::{NETWORK_STAGES, NetworkEstimate};
use crate::search::Neighbour;

/// How neighbours are weighed. The default is what the index was calibrated with; with another
/// width, the probabilities are the weights' shares, which the calibration was not fitted to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoteOptions {
    /// The kernel's width, in units of descriptor distance, in place of the index's own.
    pub sigma: Option<f64>,
    /// A factor on sigma, in place of the index's own calibrated one.
    pub sigma_scale: Option<f64>,
    /// Take Equation 5 as it is printed, which makes every weight all but 1, in place of its words.
    /// Both other widths take precedence.
    pub literal_sigma: bool,
    /// Take Equation 4 literally, as a cyclic mean of each Euler angle by itself, in place of the
    /// mean rotation.
    pub euler_mean: bool,
}

impl VoteOptions {
    /// Whether the kernel's width is another than the calibrated one.
    pub fn has_own_width(&self) -> bool {
        self.sigma.is_some() || self.sigma_scale.is_some() || self.literal_sigma
    }
}

/// One look at a picture: what lies nearest to its descriptor.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// The nearest entries.
    pub neighbours: &'a [Neighbour],
    /// What the network that described the picture says of it by itself, if anything.
    pub opinion: Option<&'a NetworkEstimate>,
    /// By how many degrees, clockwise, the picture had been turned beside the one that is asked
    /// about.
    pub turn_deg: f64,
}

/// The answer of the neighbours, and of the network that looked where it has an opinion.
#[derive(Clone, Debug, PartialEq)]
pub struct Vote {
    /// Every class of the index, most probable first; equals by class number.
    pub classes: Vec<ClassScore>,
    /// How probable the stages reach, close and grasp are by the opinions of the looks, each 0 to
    /// 1; `None` without opinions.
    pub stages: Option<[f64; NETWORK_STAGES.len()]>,
    /// The sum of Equation 3's weights over all neighbours, from 0 (nothing alike in the index) to
    /// the number of neighbours; of several looks the mean.
    pub kernel_mass: f64,
    /// The orientation, from the neighbours of the first class, and from the rotations of opinions,
    /// which count as much as these neighbours together.
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
    /// How probable it is, 0 to 1: all classes sum to 1. [`Calibration`] makes it of the share;
    /// opinions join by their logarithms.
    pub probability: f64,
    /// Equation 3's sum for the class, divided by that of all classes: 0 to 1; of several looks the
    /// mean.
    pub share: f64,
}

impl ClassScore {
    /// Puts the most probable class first, equals in the order of their numbers.
    pub fn rank(classes: &mut [Self]) {
        classes.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.class.cmp(&b.class)));
    }
}
