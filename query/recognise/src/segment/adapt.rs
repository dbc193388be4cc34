//! The published skin model, adapted to the light, the colours and the place of the hand in the
//! picture at hand.
//!
//! Argyros and Lourakis ("Real-time tracking of multiple skin-colored objects with a possibly
//! moving camera", ECCV 2004) blend the trained P(skin | colour) with one that is counted over what
//! was lately taken for skin: P = gamma P_trained + (1 - gamma) P_counted. A single picture has no
//! past, so here the picture's own likely pixels are counted, a few times over, as GrabCut does
//! (Rother, Kolmogorov and Blake, SIGGRAPH 2004). The blend is taken on log-odds, where a colour
//! that either model is sure about keeps its say.

use super::light::Light;
use super::place::{Ellipse, centrality};
use super::smooth::Smooth;
use super::{colours, colours::Colours, skin};
use crate::picture::Picture;

/// The numbers of the adaptation.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptParams {
    /// How often the picture's own pixels are counted anew; 0 leaves the published model alone.
    pub rounds: usize,
    /// The weight of the published model, 0..=1.
    pub gamma: f32,
    /// Added to the log-odds of the published model: photographs of one hand have more skin than
    /// the web has.
    pub prior: f32,
    /// The published model's log-odds lie within plus and minus this.
    pub trust: f32,
    /// The same where something else has seen the hand, too: wood that has the colour of skin is
    /// then not taken for it for certain.
    pub trust_beside_seen: f32,
    /// How much of a colour cast is taken out, 0 (none) to 1 (white becomes white).
    pub cast: f32,
    /// How strongly the middle of the picture is preferred when pixels are counted: see
    /// `place::centrality`.
    pub centre: f32,
    /// How decidedly a pixel is counted for one side: log-odds are multiplied by this first. A held
    /// object in the middle is none too likely to be skin; counted by halves it would come to look
    /// like it.
    pub decision: f32,
    /// The weight of what something else has seen beside the published model, and beside the
    /// counted colours. Masks of the scene network are coarse: with more, the border suffers.
    pub seen_first: f32,
    /// See [`Self::seen_first`].
    pub seen: f32,
    /// The share of all pixels that a bin needs before it is believed.
    pub doubt: f32,
    /// The squared Mahalanobis distance from the hand's middle at which a pixel begins to be too
    /// far off.
    pub near: f32,
    /// Log-odds lost by each unit of that distance farther off, and the most that can be lost.
    pub off: f32,
    /// See [`Self::off`].
    pub most_off: f32,
    /// How far values are averaged over a surface, in pixels.
    pub reach: f32,
    /// The difference of colours, summed over three channels, that counts as an edge.
    pub edge: f32,
}

impl Default for AdaptParams {
    fn default() -> Self {
        Self {
            rounds: 5,
            gamma: 0.2,
            prior: 1.5,
            trust: 3.0,
            trust_beside_seen: 2.0,
            cast: 0.7,
            centre: 3.0,
            decision: 4.0,
            seen_first: 1.0,
            seen: 0.1,
            doubt: 2e-4,
            near: 3.0,
            off: 0.5,
            most_off: 2.0,
            reach: 10.0,
            edge: 30.0,
        }
    }
}

/// The log-odds of skin at each pixel of a picture, averaged over its surfaces.
#[derive(Clone, Debug)]
pub struct Odds {
    /// By colour alone.
    pub colour: Vec<f32>,
    /// By colour, less what is lost far off the hand's middle.
    pub placed: Vec<f32>,
}

/// The log-odds of skin at each pixel of a picture of at most some 160 pixels a side.
///
/// `seen` are log-odds of a hand at each pixel by something else than colour, where there is such a
/// thing: they are added to those of the published model.
pub fn log_odds(picture: &Picture, params: &AdaptParams, seen: Option<&[f32]>) -> Odds {
    let (width, height) = (picture.width(), picture.height());
    let light = Light::of(picture, params.cast);
    let trust = if seen.is_some() { params.trust_beside_seen } else { params.trust };
    let published = picture
        .rgb()
        .iter()
        .map(|&rgb| (skin::log_odds(light.correct(rgb)) + params.prior).clamp(-trust, trust));
    let trained: Vec<f32> = match seen {
        None => published.collect(),
        Some(seen) => published.zip(seen).map(|(skin, seen)| skin + params.seen_first * seen).collect(),
    };
    let bins: Vec<u16> = picture.rgb().iter().map(|&rgb| colours::bin(rgb)).collect();
    let mut colours = Colours::of(&bins);
    let smooth = Smooth::new(picture, params.reach, params.edge);
    let centred = centrality(width, height, params.centre);
    // How much each pixel is taken for hand, and what a step needs for itself.
    let (mut hand, mut spare) = (vec![0.0; trained.len()], Vec::new());
    let mut colour = trained.clone();
    let mut placed = trained.clone();
    smooth.apply(&mut placed, &mut spare);
    for _ in 0..params.rounds {
        for ((hand, &odds), centred) in hand.iter_mut().zip(&placed).zip(&centred) {
            *hand = probability(params.decision * odds) * centred;
        }
        for ((colour, &trained), counted) in
            colour.iter_mut().zip(&trained).zip(colours.log_odds(&hand, params.doubt))
        {
            *colour = params.gamma * trained + (1.0 - params.gamma) * counted;
        }
        Ellipse::of(width, &hand).distances(width, height, &mut spare);
        for ((placed, colour), distance) in placed.iter_mut().zip(&colour).zip(&spare) {
            *placed = colour - (params.off * (distance - params.near)).clamp(0.0, params.most_off);
        }
        if let Some(seen) = seen {
            placed.iter_mut().zip(seen).for_each(|(placed, seen)| *placed += params.seen * seen);
        }
        smooth.apply(&mut placed, &mut spare);
    }
    smooth.apply(&mut colour, &mut spare);
    Odds { colour, placed }
}

/// Much like 1 / (1 + e^-odds), but 0 and 1 from -4 and 4 on, and without an exponential for each
/// pixel.
fn probability(odds: f32) -> f32 {
    let share = (0.5 + odds / 8.0).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of one colour on a ground of another.
    fn patch(skin: [u8; 3], ground: [u8; 3]) -> Picture {
        let inside = |at: usize| (20..44).contains(&(at % 64)) && (20..44).contains(&(at / 64));
        let rgb = (0..64 * 64).map(|at| if inside(at) { skin } else { ground }).collect();
        Picture::new(64, 64, rgb).unwrap()
    }

    #[test]
    fn skin_in_dim_light_is_found_by_its_difference_from_the_ground() {
        // Indoors, by the window: the published model alone calls this brown no skin.
        let picture = patch([74, 51, 50], [178, 182, 186]);
        assert!(skin::log_odds([74, 51, 50]) < 0.5);
        let odds = log_odds(&picture, &AdaptParams::default(), None).placed;
        assert!(odds[32 * 64 + 32] > 1.0, "hand {}", odds[32 * 64 + 32]);
        assert!(odds[5 * 64 + 5] < -1.0, "ground {}", odds[5 * 64 + 5]);
    }

    #[test]
    fn a_picture_of_one_blue_has_no_skin() {
        let odds = log_odds(&patch([40, 70, 160], [40, 70, 160]), &AdaptParams::default(), None);
        assert!(odds.placed.iter().all(|&odds| odds < 0.0));
    }

    #[test]
    fn a_black_thing_in_the_middle_of_a_hand_does_not_come_to_look_like_skin() {
        let held = |at: usize| (27..37).contains(&(at % 64)) && (27..37).contains(&(at / 64));
        let hand = patch([200, 140, 110], [90, 130, 90]);
        let rgb =
            hand.rgb().iter().enumerate().map(|(at, &rgb)| if held(at) { [35; 3] } else { rgb }).collect();
        let odds = log_odds(&Picture::new(64, 64, rgb).unwrap(), &AdaptParams::default(), None).placed;
        assert!(odds[32 * 64 + 32] < -0.5, "held {}", odds[32 * 64 + 32]);
        assert!(odds[22 * 64 + 32] > 1.0, "hand {}", odds[22 * 64 + 32]);
    }

    #[test]
    fn wood_of_the_colour_of_skin_is_less_likely_far_from_the_hand() {
        let hand = patch([200, 140, 110], [90, 130, 90]);
        let wood = |at: usize| at % 64 >= 56;
        let rgb =
            hand.rgb().iter().enumerate().map(|(at, &rgb)| if wood(at) { [200, 140, 110] } else { rgb });
        let odds = log_odds(&Picture::new(64, 64, rgb.collect()).unwrap(), &AdaptParams::default(), None);
        assert!(odds.placed[60] < odds.colour[60] - 1.0);
        assert!(odds.placed[32 * 64 + 32] > odds.placed[60]);
    }

    #[test]
    fn a_box_of_the_colour_of_skin_is_no_hand_where_something_else_has_seen_the_hand() {
        let is_hand = |at: usize| at % 64 < 16;
        let wood = patch([165, 105, 80], [90, 130, 90]);
        let rgb = wood.rgb().iter().enumerate();
        let rgb = rgb.map(|(at, &rgb)| if is_hand(at) { [200, 140, 110] } else { rgb }).collect();
        let picture = Picture::new(64, 64, rgb).unwrap();
        let seen: Vec<f32> = (0..64 * 64).map(|at| if is_hand(at) { 3.0 } else { -3.0 }).collect();
        let of = |seen| log_odds(&picture, &AdaptParams::default(), seen).placed;
        let (hand, wood) = (32 * 64 + 8, 32 * 64 + 32);
        assert!(of(None)[wood] > 1.0, "by colour it is skin: {}", of(None)[wood]);
        let beside = of(Some(seen.as_slice()));
        assert!(beside[hand] > 1.0 && beside[wood] < -1.0, "{} {}", beside[hand], beside[wood]);
    }
}
