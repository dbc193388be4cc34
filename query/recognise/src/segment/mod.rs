//! Which pixels of a camera picture are the hand (the paper's Section III).
//!
//! On the picture at a small size: skin log-odds of each colour ([`skin`]), re-estimated from the
//! picture's own light, colours and places ([`adapt`]), grown from sure to likely pixels
//! ([`hysteresis`]), median filtered ([`median`]), reduced to the most hand-like component and what
//! belongs to it ([`component`]), made whole across a watch ([`band`]). The border is then found at
//! the full size, and the forearm cut off at the wrist ([`wrist`]). Depth pictures and masks made
//! elsewhere enter by [`depth`] and [`Mask::from_grey`].

pub mod adapt;
pub mod band;
pub mod component;
pub mod depth;
pub mod hysteresis;
pub mod median;
pub mod quality;
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
pub use quality::Quality;

#[cfg(feature = "landmarks")]
use crate::mediapipe::HandNetworks;
use crate::networks::Networks;
use crate::picture::Picture;
use distance::Deepest;

/// What finds the hand in a camera picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Finder {
    /// A network that was trained on scenes ([`crate::scene`]).
    #[default]
    Scene,
    /// The colour of skin, as in the paper's Section III ([`segment`]).
    Skin,
    /// MediaPipe's networks find the hand's joints, and from there the network of scenes goes on.
    #[cfg(feature = "landmarks")]
    Landmarks(HandNetworks),
}

/// The numbers of the segmentation; log-odds in natural units, above 0 where skin is the likelier.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentParams {
    /// What finds the hand in a camera picture.
    pub by: Finder,
    /// The networks that look at scenes, and at what was found in them.
    pub networks: Networks,
    /// The longest side, in pixels, at which the hand is looked for; its border is found at the
    /// full size.
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
    /// The smallest share of a hand's pixels that the published model must find possible, the light
    /// set right but nothing else adapted: what follows a picture's own colours far enough finds
    /// skin on a white bottle.
    pub min_published: f32,
}

impl Default for SegmentParams {
    fn default() -> Self {
        Self {
            by: Finder::default(),
            networks: Networks::default(),
            side: 160,
            adapt: adapt::AdaptParams::default(),
            sure: 1.0,
            likely: 0.0,
            median_passes: 3,
            companions: component::CompanionParams::default(),
            min_share: 0.004,
            min_published: 0.1,
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
    /// What speaks for and against `skin`.
    pub quality: Quality,
}

/// Finds the hand in a colour picture, or `None` where nothing looks like one.
pub fn segment(picture: &Picture, params: &SegmentParams) -> Option<Segmentation> {
    segment_seen(picture, params, None)
}

/// The same where something else than colour has seen the hand, too: `seen` are its log-odds at a
/// place of the picture, in pixels.
pub(crate) fn segment_seen(
    picture: &Picture,
    params: &SegmentParams,
    seen: Option<&dyn Fn([f64; 2]) -> f32>,
) -> Option<Segmentation> {
    let factor = picture.shrink_factor(params.side);
    let shrunk = picture.shrunk(factor);
    let seen: Option<Vec<f32>> = seen.map(|seen| {
        let places =
            (0..shrunk.width() * shrunk.height()).map(|at| [at % shrunk.width(), at / shrunk.width()]);
        places.map(|place| seen(place.map(|v| (v as f64 + 0.5) * factor as f64))).collect()
    });
    let fewest = component::MIN_PIXELS / (factor * factor);
    let (small, deepest, quality) = find(&shrunk, fewest, params, seen.as_deref())?;
    let mut skin = refine::enlarge(&small, &shrunk, picture, factor);
    for _ in 1..params.median_passes {
        skin = median::median3x3(&skin);
    }
    let hand = wrist::cut_at_wrist(&skin, &small, deepest, factor);
    Some(Segmentation { skin, hand, quality })
}

/// The hand and its forearm in a small picture, with their deepest place; a hand has at least
/// `fewest` pixels.
fn find(
    picture: &Picture,
    fewest: usize,
    params: &SegmentParams,
    seen: Option<&[f32]>,
) -> Option<(Mask, Option<Deepest>, Quality)> {
    let (width, height) = (picture.width(), picture.height());
    let odds = adapt::log_odds(picture, &params.adapt, seen);
    let mut mask = hysteresis::grow(width, height, &odds.placed, params.sure, params.likely);
    if params.median_passes > 0 {
        mask = median::median3x3(&mask);
    }
    let smallest = (params.min_share * (width * height) as f32) as usize;
    let hand = component::most_hand_like(&mask, &odds.placed, smallest.max(fewest))?;
    if seen.is_none() && published_share(picture, &hand, params.adapt.cast) < params.min_published {
        return None;
    }
    let whole = band::bridge(&component::with_companions(&hand, &odds.colour, &params.companions));
    let deepest = Deepest::of(&whole);
    let quality = Quality::of(&whole, deepest, &odds.colour);
    Some((whole, deepest, quality))
}

/// Log-odds of the published model below which a colour is no skin under any light.
const IMPOSSIBLE: f32 = -1.0;

/// The share of a mask's pixels whose colour may be skin to the published model.
fn published_share(picture: &Picture, mask: &Mask, cast: f32) -> f32 {
    let light = light::Light::of(picture, cast);
    let pixels = picture.rgb().iter().zip(mask.pixels()).filter(|(_, inside)| **inside != 0);
    let is_possible = pixels.filter(|(rgb, _)| skin::log_odds(light.correct(**rgb)) > IMPOSSIBLE).count();
    is_possible as f32 / mask.area().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIN: [u8; 3] = [205, 145, 115];
    const BLACK: [u8; 3] = [28, 28, 30];
    const CLOTH: [u8; 3] = [90, 120, 100];

    /// A picture of 320 x 240 whose pixels have the colour that `colour` gives for their place.
    fn picture(colour: impl Fn(usize, usize) -> [u8; 3]) -> Picture {
        Picture::new(320, 240, (0..320 * 240).map(|at| colour(at % 320, at / 320)).collect()).unwrap()
    }

    fn is_palm(x: usize, y: usize) -> bool {
        (x as f32 - 150.0).hypot(y as f32 - 120.0) < 45.0
    }

    #[test]
    fn an_arm_is_whole_across_its_watch_and_the_hand_ends_there() {
        let arm = |x: usize, y: usize| x >= 150 && (93..147).contains(&y);
        let found = segment(
            &picture(|x, y| match (is_palm(x, y) || arm(x, y), (205..225).contains(&x)) {
                (true, true) => BLACK,
                (true, false) => SKIN,
                _ => CLOTH,
            }),
            &SegmentParams::default(),
        )
        .unwrap();
        let whole: Vec<bool> =
            (0..320 * 240).map(|at| is_palm(at % 320, at / 320) || arm(at % 320, at / 320)).collect();
        let whole = Mask::from_values(320, 240, &whole, |v| v);
        assert!(found.skin.iou(&whole).unwrap() > 0.95, "{:?}", found.skin.iou(&whole));
        assert!(found.hand.get(150, 120) && !found.hand.get(280, 120));
    }

    #[test]
    fn fingertips_beyond_a_held_bottle_belong_to_the_hand_and_the_bottle_does_not() {
        let bottle = |x: usize| (115..150).contains(&x);
        let finger = |x: usize, y: usize| (100..115).contains(&x) && (95..145).contains(&y);
        let found = segment(
            &picture(|x, y| match (bottle(x), is_palm(x, y) || finger(x, y)) {
                (true, _) => BLACK,
                (false, true) => SKIN,
                _ => CLOTH,
            }),
            &SegmentParams::default(),
        )
        .unwrap();
        assert!(found.hand.get(107, 120), "fingers");
        assert!(found.hand.get(175, 120), "palm");
        assert!(!found.hand.get(132, 120) && !found.hand.get(132, 20), "bottle");
    }

    #[test]
    fn a_white_bottle_before_a_wall_is_no_hand() {
        let bottle = |x: usize, y: usize| (130..190).contains(&x) && (40..220).contains(&y);
        let found = picture(|x, y| if bottle(x, y) { [225, 222, 218] } else { [120, 130, 140] });
        assert_eq!(segment(&found, &SegmentParams::default()), None);
    }
}
