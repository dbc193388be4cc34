//! Which pixels of a camera picture are the hand (the paper's Section III).
//!
//! The chain: skin log-odds of each colour ([`skin`]), re-estimated from the picture's own sure pixels
//! ([`adapt`]), grown from sure to likely pixels ([`hysteresis`]), median filtered three times ([`median`]),
//! reduced to the most hand-like component ([`component`]), and cut at the wrist ([`wrist`]).
//! Depth pictures and masks made elsewhere enter by [`depth`] and [`Mask::from_grey`].

pub mod adapt;
pub mod component;
pub mod depth;
pub mod hysteresis;
pub mod median;
pub mod skin;
pub mod wrist;

mod mask;
#[cfg(test)]
mod tests_support;

pub use mask::{Mask, MaskError};

use crate::picture::Picture;

/// The numbers of the segmentation; log-odds in natural units, above 0 where skin is the likelier.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentParams {
    /// How a picture's own colours change the published model.
    pub adapt: adapt::AdaptParams,
    /// Log-odds above which a pixel starts a region.
    pub sure: f32,
    /// Log-odds above which a pixel joins a region that it touches.
    pub likely: f32,
    /// Radius, in pixels, of the box over which log-odds are averaged before the thresholds.
    pub smooth_radius: usize,
    /// Passes of the 3 x 3 median; the paper has three.
    pub median_passes: usize,
    /// The smallest share of the picture that a hand may fill.
    pub min_share: f32,
    /// The smallest share of a hand's pixels that the published model must take for skin without any adaptation:
    /// what follows a picture's own light far enough finds skin on a white bottle.
    pub min_published: f32,
}

impl Default for SegmentParams {
    fn default() -> Self {
        Self {
            adapt: adapt::AdaptParams::default(),
            sure: 1.0,
            likely: 0.0,
            smooth_radius: 1,
            median_passes: 3,
            min_share: 0.004,
            min_published: 0.02,
        }
    }
}

/// What the segmentation of a picture found.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// The component of skin, forearm included.
    pub skin: Mask,
    /// The hand: `skin` cut at the wrist.
    pub hand: Mask,
}

/// Finds the hand in a colour picture, or `None` where nothing looks like one.
pub fn segment(picture: &Picture, params: &SegmentParams) -> Option<Segmentation> {
    let (width, height) = (picture.width(), picture.height());
    let odds = adapt::log_odds(picture, params.smooth_radius, &params.adapt);
    let mut mask = hysteresis::grow(width, height, &odds, params.sure, params.likely);
    for _ in 0..params.median_passes {
        mask = median::median3x3(&mask);
    }
    let smallest = (params.min_share * (width * height) as f32) as usize;
    let skin = component::most_hand_like(&mask, &odds, smallest.max(component::MIN_PIXELS))?;
    if published_share(picture, &skin) < params.min_published {
        return None;
    }
    let hand = wrist::cut_forearm(&skin);
    Some(Segmentation { skin, hand })
}

/// The share of a mask's pixels whose colour is skin to the published model.
fn published_share(picture: &Picture, mask: &Mask) -> f32 {
    let pixels = picture.rgb().iter().zip(mask.pixels()).filter(|(_, inside)| **inside != 0);
    let is_skin = pixels.filter(|(rgb, _)| skin::log_odds(**rgb) > 0.0).count();
    is_skin as f32 / mask.area().max(1) as f32
}
