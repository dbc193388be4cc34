//! How pictures are recognised.

use grasp_index::{Effort, SearchOptions, VoteOptions};

use crate::segment::SegmentParams;
use crate::side::HandChoice;

/// Rolls tried for each picture unless told otherwise: the picture as it is.
///
/// On development pictures 1, 8 and 12 rolls class equally well, upright hands (45, 46 and 44 % of
/// 646, the hand given) and photographs alike, but more rolls cost orientation (median error 12.6,
/// 14.1 and 16.1 degrees) and time.
pub const DEFAULT_ROLLS: usize = 1;

/// How pictures are recognised.
#[derive(Clone, Debug)]
pub struct RecogniseOptions {
    /// Which hand the pictures show.
    pub hand: HandChoice,
    /// How many turns about the optical axis are tried, evenly over the circle, beside the one that
    /// the index's descriptors want ([`grasp_index::DescriptorParams::turn_deg`]); 1 tries none
    /// besides.
    pub rolls: usize,
    /// Whether a camera picture, in which scene networks find the hand, is also looked at mirrored,
    /// turned, in other light and enlarged: ten times the work for an answer that depends less on
    /// how the picture happens to be taken.
    pub thorough: bool,
    /// How many neighbours vote; `None` takes the index's own number.
    pub k: Option<usize>,
    /// How hard to look for neighbours.
    pub effort: Effort,
    /// How neighbours are weighed.
    pub vote: VoteOptions,
    /// When an answer is one.
    pub accept: Accept,
    /// Whether probabilities are tempered by the trust in a hand that was found in a camera
    /// picture, and one of too little trust is unknown.
    pub temper: bool,
    /// The numbers of the segmentation.
    pub segment: SegmentParams,
}

impl Default for RecogniseOptions {
    fn default() -> Self {
        Self {
            hand: HandChoice::default(),
            rolls: DEFAULT_ROLLS,
            thorough: false,
            k: None,
            effort: SearchOptions::default().effort,
            vote: VoteOptions::default(),
            accept: Accept::default(),
            temper: true,
            segment: SegmentParams::default(),
        }
    }
}

/// What is taken for an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Accept {
    /// Everything.
    Always,
    /// What lies within the limits that the index was calibrated with.
    #[default]
    Calibrated,
    /// What has its nearest neighbour within this distance.
    Within(f64),
}
