//! What a hand that was found is, and what it does.

use super::find::Detection;
use super::look::Eye;
use super::network::{SceneNetwork, normalised};
use super::square::Square;
use crate::picture::Picture;
use crate::segment::Mask;
use crate::side::Side;

/// Looks at a hand: turned and enlarged by so much.
const LOOKS: [(f64, f64); 3] = [(0.0, 1.0), (0.22, 1.12), (-0.22, 0.92)];
/// The least probability that is divided by.
const LEAST: f64 = 1e-6;

/// What the network says of a picture.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where the hand was found.
    pub found: Detection,
    /// The square in which it was looked at in the end.
    pub square: Square,
    /// The logarithm of how much likelier a right hand is than a left one.
    pub right_odds: f64,
    /// The grasps' names.
    pub(super) grasps: Vec<String>,
    /// For a right and for a left hand, the logarithm of each grasp's probability by all that is
    /// seen, in the order of the names, then that of none.
    by_side: [Vec<f64>; 2],
}

impl Scene {
    /// Looks at a hand, whose mask was found on the same picture, as a right one and as a left one.
    pub fn new(network: &SceneNetwork, picture: &Picture, found: Detection, hand: &Mask) -> Self {
        let square = found.square_of(hand);
        let mut eye = Eye::new(network, picture);
        let [right, left] = [false, true].map(|is_mirrored| looks(&mut eye, &square, is_mirrored));
        Self {
            right_odds: 0.5 * (right.odds - left.odds) + found.right_odds,
            found,
            square,
            grasps: network.grasps.clone(),
            by_side: [right.grasps, left.grasps],
        }
    }

    /// How likely each grasp is if the hand is this one, in the order of the network's names; then
    /// how likely it is in none of them. The probabilities sum to 1.
    pub fn probabilities(&self, side: Side) -> Vec<f64> {
        let logs = &self.by_side[usize::from(side == Side::Left)];
        logs.iter().copied().map(libm::exp).collect()
    }
}

/// What several looks at one of both hands say.
struct Named {
    /// The mean log-odds of its being that hand.
    odds: f64,
    /// The logarithm of each grasp's probability, then that of none.
    grasps: Vec<f64>,
}

fn looks(eye: &mut Eye<'_>, square: &Square, is_mirrored: bool) -> Named {
    let grasps = eye.network.grasps.len();
    let (mut odds, mut sum) = (0.0, vec![0.0; grasps + 1]);
    for (turn, size) in LOOKS {
        let square = Square { turn: square.turn + turn, side: square.side * size, ..*square };
        let classes = eye.look(&square, is_mirrored).classes;
        let mirrored = classes[grasps];
        odds += libm::log((-libm::expm1(mirrored)).max(LEAST)) - mirrored;
        let shown = classes[..grasps].iter().chain(&classes[grasps + 1..]);
        sum.iter_mut().zip(shown).for_each(|(sum, log)| *sum += log);
    }
    let count = LOOKS.len() as f64;
    let means: Vec<f64> = sum.iter().map(|sum| sum / count).collect();
    Named { odds: odds / count, grasps: normalised(&means) }
}
