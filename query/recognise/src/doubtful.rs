//! What of an answer is doubtful.

use crate::recognition::Recognition;
use crate::trust::MOST_FILLED;
use crate::warning::Warning;

/// A mask that was found in a camera picture and fills more than that is rather a background; 1 of
/// 1,000 development hands fills more.
const MOST_FOUND: f64 = 0.5;
/// The share of a side's length that must lie in the mask for it to touch.
const TOUCHED: f64 = 0.05;
/// The share of skin-coloured surroundings from which on an outline is doubtful; 1 of 100 hands on
/// plain ground has more.
const SKIN_AROUND: f64 = 0.2;
/// The trust below which a reader is warned.
const LITTLE_TRUST: f64 = 0.3;
/// The share of the farthest distance from which on an entry is far.
const FAR: f64 = 0.9;
/// The disagreement from which on it is pointed out, in degrees.
const DISAGREE_DEG: f64 = 45.0;
/// The probability of none of the grasps from which on it is pointed out.
const MAYBE_NONE: f64 = 0.3;
/// Hands whose neighbours' distances differ by less than this share are told apart by chance.
const AS_NEAR: f64 = 0.01;

/// What there is to doubt about an answer. `is_calibrated`: whether there is a calibration that
/// holds for it.
pub(crate) fn warnings(found: &Recognition, is_calibrated: bool) -> Vec<Warning> {
    let (mask, evidence) = (&found.prepared.mask, &found.evidence);
    let share = evidence.share;
    let mut warnings: Vec<Warning> = Vec::new();
    let mut warn = |is_so: bool, warning: Warning| {
        if is_so {
            warnings.push(warning);
        }
    };
    let filled = if found.prepared.skin.is_some() { MOST_FOUND } else { MOST_FILLED };
    warn(share > filled, Warning::MaskFillsFrame { share });
    // A given mask may be cropped on purpose, and an arm that was cut off at the wrist crosses the
    // border by its nature.
    if found.prepared.skin.is_some() {
        let lengths = [mask.width(), mask.width(), mask.height(), mask.height()];
        let touches = |&(on_side, length): &(usize, usize)| on_side as f64 > TOUCHED * length as f64;
        let sides = mask.on_sides().into_iter().zip(lengths).filter(touches).count();
        warn(sides > 0, Warning::MaskTouchesBorder { sides });
    }
    if let Some(quality) = &evidence.quality {
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
    if let Some(probability) = found.no_grasp {
        warn(probability > MAYBE_NONE, Warning::NoneOfTheGrasps { probability });
    }
    warn(!is_calibrated, Warning::IndexNotCalibrated);
    warnings
}

/// Says how far the neighbours that an answer goes by disagree, in degrees, in place of what was
/// said of others.
pub(crate) fn point_out_disagreement(warnings: &mut Vec<Warning>, spread_deg: f64) {
    warnings.retain(|warning| !matches!(warning, Warning::NeighboursDisagree { .. }));
    if spread_deg > DISAGREE_DEG {
        warnings.push(Warning::NeighboursDisagree { spread_deg });
    }
}
