//! What should make a reader doubt an answer, whether or not it is one.

use super::Recognition;
use super::trust::MOST_FILLED;

/// A reason for doubt. Kinds are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The picture was decoded, but not all of it as it should be.
    #[error("{0}")]
    Decoding(String),
    /// The mask fills most of the picture.
    #[error(
        "what was taken for the hand fills {:.0} % of the picture: a hand before a background is needed",
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
        "{:.0} % of what surrounds the hand has the colour of skin: its outline may be wrong (give a mask with --mask)",
        100.0 * skin_around
    )]
    SegmentationDoubtful {
        /// The share of the surroundings, 0..=1.
        skin_around: f64,
    },
    /// The picture is unlike those that were recognised rightly when trust was fitted.
    #[error(
        "pictures like this one are often recognised wrongly: the neighbours' agreement counts by {trust:.2} (1: fully)"
    )]
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
    #[error("it may as well be the other hand: say which with --hand")]
    HandAmbiguous,
    /// The index has no calibration.
    #[error("the index is not calibrated: probabilities are shares of the neighbours' votes")]
    IndexNotCalibrated,
}

/// A mask found by colour that fills more than that is rather a background; 1 of 1,000 development hands fills more.
const FILLED_BY_COLOUR: f64 = 0.5;
/// The share of a side's length that must lie in the mask for it to touch.
const TOUCHED: f64 = 0.05;
/// The share of skin-coloured surroundings from which on an outline is doubtful; 1 of 100 hands on plain ground has more.
const SKIN_AROUND: f64 = 0.2;
/// The trust below which a reader is warned.
const LITTLE_TRUST: f64 = 0.3;
/// The share of the farthest distance from which on an entry is far.
const FAR: f64 = 0.9;
/// The disagreement from which on it is pointed out, in degrees.
const DISAGREE_DEG: f64 = 45.0;
/// Hands whose neighbours' distances differ by less than this share are told apart by chance.
const AS_NEAR: f64 = 0.01;

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
            Self::IndexNotCalibrated => "index_not_calibrated",
        }
    }
}

/// What there is to doubt about an answer. `is_calibrated`: whether the index's calibration holds for it.
pub(super) fn of(found: &Recognition, is_calibrated: bool) -> Vec<Warning> {
    let (mask, evidence) = (&found.prepared.mask, &found.evidence);
    let share = evidence.share;
    let mut warnings: Vec<Warning> = Vec::new();
    let mut warn = |is_so: bool, warning: Warning| {
        if is_so {
            warnings.push(warning);
        }
    };
    let filled = if evidence.quality.is_some() { FILLED_BY_COLOUR } else { MOST_FILLED };
    warn(share > filled, Warning::MaskFillsFrame { share });
    // A given mask may be cropped on purpose, and an arm that was cut off at the wrist crosses the border by its nature.
    if let Some(quality) = &evidence.quality {
        let lengths = [mask.width(), mask.width(), mask.height(), mask.height()];
        let touches = |&(on_side, length): &(usize, usize)| on_side as f64 > TOUCHED * length as f64;
        let sides = mask.on_sides().into_iter().zip(lengths).filter(touches).count();
        warn(sides > 0, Warning::MaskTouchesBorder { sides });
        let skin_around = quality.skin_around;
        warn(skin_around > SKIN_AROUND, Warning::SegmentationDoubtful { skin_around });
    }
    if let Some(trust) = found.trust {
        warn(trust < LITTLE_TRUST, Warning::PictureUnlikeCalibration { trust });
    }
    if let Some(nearest) = evidence.nearest {
        warn(nearest > FAR, Warning::NeighboursFar { nearest });
    }
    let spread_deg = evidence.spread_deg;
    warn(spread_deg > DISAGREE_DEG, Warning::NeighboursDisagree { spread_deg });
    warn(evidence.other_hand.is_some_and(|farther| farther < AS_NEAR), Warning::HandAmbiguous);
    warn(!is_calibrated, Warning::IndexNotCalibrated);
    warnings
}
