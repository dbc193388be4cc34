//! Which pixels of a camera picture are the hand (the paper's Section III).
//!
//! On the picture at a small size: skin log-odds of each colour ([`skin`]), re-estimated from the picture's own light,
//! colours and places ([`adapt`]), grown from sure to likely pixels ([`hysteresis`]), median filtered ([`median`]),
//! reduced to the most hand-like component and what belongs to it ([`component`]), made whole across a watch
//! ([`band`]). The border is then found at the full size, and the forearm cut off at the wrist ([`wrist`]).
//! Depth pictures and masks made elsewhere enter by [`depth`] and [`Mask::from_grey`].

pub mod adapt;
pub mod band;
pub mod component;
pub mod depth;
pub mod hysteresis;
pub mod median;
pub mod skin;
pub mod wrist;

mod colours;
mod distance;
mod light;
mod mask;
mod place;
mod refine;
mod smooth;
#[cfg(test)]
mod tests_support;

pub use mask::{Mask, MaskError};

use crate::picture::Picture;

/// The numbers of the segmentation; log-odds in natural units, above 0 where skin is the likelier.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentParams {
    /// The longest side, in pixels, at which the hand is looked for; its border is found at the full size.
    pub side: usize,
    /// How a picture's own colours change the published model.
    pub adapt: adapt::AdaptParams,
    /// Log-odds above which a pixel starts a region.
    pub sure: f32,
    /// Log-odds above which a pixel joins a region that it touches.
    pub likely: f32,
    /// Passes of the 3 x 3 median, one of them at the small size; the paper has three.
    pub median_passes: usize,
    /// What else belongs to the hand.
    pub companions: component::CompanionParams,
    /// The smallest share of the picture that a hand may fill.
    pub min_share: f32,
    /// The smallest share of a hand's pixels that the published model must take for skin without any adaptation:
    /// what follows a picture's own light far enough finds skin on a white bottle.
    pub min_published: f32,
}

impl Default for SegmentParams {
    fn default() -> Self {
        Self {
            side: 160,
            adapt: adapt::AdaptParams::default(),
            sure: 1.0,
            likely: 0.0,
            median_passes: 3,
            companions: component::CompanionParams::default(),
            min_share: 0.004,
            min_published: 0.02,
        }
    }
}

/// What the segmentation of a picture found.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// The hand and its forearm, a watch between them included.
    pub skin: Mask,
    /// The hand: `skin` cut at the wrist.
    pub hand: Mask,
}

/// Finds the hand in a colour picture, or `None` where nothing looks like one.
pub fn segment(picture: &Picture, params: &SegmentParams) -> Option<Segmentation> {
    let factor = picture.shrink_factor(params.side);
    let shrunk = picture.clone().shrunk_to(params.side);
    let small = find(&shrunk, component::MIN_PIXELS / (factor * factor), params)?;
    let mut skin = refine::enlarge(&small, &shrunk, picture, factor);
    for _ in 1..params.median_passes {
        skin = median::median3x3(&skin);
    }
    let hand = wrist::cut_forearm(&skin, &small, factor);
    Some(Segmentation { skin, hand })
}

/// The hand and its forearm in a small picture; a hand has at least `fewest` pixels.
fn find(picture: &Picture, fewest: usize, params: &SegmentParams) -> Option<Mask> {
    let (width, height) = (picture.width(), picture.height());
    let odds = adapt::log_odds(picture, &params.adapt);
    let mut mask = hysteresis::grow(width, height, &odds.placed, params.sure, params.likely);
    if params.median_passes > 0 {
        mask = median::median3x3(&mask);
    }
    let smallest = (params.min_share * (width * height) as f32) as usize;
    let hand = component::most_hand_like(&mask, &odds.placed, smallest.max(fewest))?;
    if published_share(picture, &hand) < params.min_published {
        return None;
    }
    Some(band::bridge(&component::with_companions(&hand, &odds.colour, &params.companions)))
}

/// The share of a mask's pixels whose colour is skin to the published model.
fn published_share(picture: &Picture, mask: &Mask) -> f32 {
    let pixels = picture.rgb().iter().zip(mask.pixels()).filter(|(_, inside)| **inside != 0);
    let is_skin = pixels.filter(|(rgb, _)| skin::log_odds(**rgb) > 0.0).count();
    is_skin as f32 / mask.area().max(1) as f32
}
