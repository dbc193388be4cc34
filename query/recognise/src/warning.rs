//! What should make a reader doubt an answer, whether or not it is one.

/// A reason for doubt. Kinds are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The picture was decoded, but not all of it as it should be.
    #[error("{0}")]
    Decoding(String),
    /// The mask fills most of the picture.
    #[error(
        "what was taken for the hand fills {:.0} % of the picture: a hand in front of a background is needed",
        100.0 * share
    )]
    MaskFillsFrame {
        /// The share of the picture, 0..=1.
        share: f64,
    },
    /// The hand reaches the border.
    #[error("the hand touches {sides} of the picture's sides: part of it may be missing")]
    MaskTouchesBorder {
        /// How many sides.
        sides: usize,
    },
    /// What lies around the mask looks like skin, too.
    #[error(
        "{:.0} % of what surrounds the hand has the colour of skin: its outline may be wrong (a mask can be given)",
        100.0 * skin_around
    )]
    SegmentationDoubtful {
        /// The share of the surroundings, 0..=1.
        skin_around: f64,
    },
    /// The picture is unlike those that were recognised rightly when trust was fitted.
    #[error("pictures like this one are often recognised wrongly: trust {trust:.2}, where 1 is full")]
    PictureUnlikeCalibration {
        /// The trust, 0..=1.
        trust: f64,
    },
    /// The nearest entry lies about as far as a known hand can.
    #[error(
        "the nearest entry is far: at {:.0} % of the distance within which known hands lie",
        100.0 * nearest
    )]
    NeighboursFar {
        /// The distance as a share of the farthest.
        nearest: f64,
    },
    /// The neighbours are turned differently.
    #[error("the neighbours disagree by {spread_deg:.0}° about how the hand is turned")]
    NeighboursDisagree {
        /// In degrees.
        spread_deg: f64,
    },
    /// Both hands are about as likely.
    #[error("it may as well be the other hand: say which it is")]
    HandAmbiguous,
    /// The hand may hold nothing, or something in another way.
    #[error("the hand may be in none of the grasps: {:.0} % likely by all that is seen", 100.0 * probability)]
    NoneOfTheGrasps {
        /// How likely that is, 0..=1.
        probability: f64,
    },
    /// A thorough look was asked for, and the hand is none that networks found in a camera picture.
    #[error("looked at once: `thorough` is for hands that the networks find in camera pictures")]
    LookedAtOnce,
    /// The index has no calibration, or none that holds for such a vote.
    #[error("no calibration holds for this vote: its probabilities may be far off")]
    IndexNotCalibrated,
}

impl Warning {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Decoding(_) => "decoding",
            Self::MaskFillsFrame { .. } => "mask_fills_frame",
            Self::MaskTouchesBorder { .. } => "mask_touches_border",
            Self::SegmentationDoubtful { .. } => "segmentation_doubtful",
            Self::PictureUnlikeCalibration { .. } => "picture_unlike_calibration",
            Self::NeighboursFar { .. } => "neighbours_far",
            Self::NeighboursDisagree { .. } => "neighbours_disagree",
            Self::HandAmbiguous => "hand_ambiguous",
            Self::NoneOfTheGrasps { .. } => "none_of_the_grasps",
            Self::LookedAtOnce => "looked_at_once",
            Self::IndexNotCalibrated => "index_not_calibrated",
        }
    }
}
