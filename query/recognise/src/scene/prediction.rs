//! Which hand it is and what it does, by looks of networks at it.

use super::look::Eye;
use super::network::normalised;
use super::square::Square;
use crate::side::Side;

/// Looks at a hand: turned and enlarged by so much.
const LOOKS: [(f64, f64); 3] = [(0.0, 1.0), (0.22, 1.12), (-0.22, 0.92)];
/// How much the network counts that finds hands; the rest is that of the network that has learned
/// to name them. Chosen on pictures of two hands (docs/accuracy.md).
const FINDING: f64 = 0.4;
/// The least probability that is divided by.
const LEAST: f64 = 1e-6;

/// Which hand it is, and what it does, by what the networks see.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The logarithm of how much likelier a right hand is than a left one.
    pub right_odds: f64,
    /// The grasps' names.
    pub(super) grasps: Vec<String>,
    /// How it joins what the neighbours say.
    pub(super) powers: Powers,
    /// For a right and for a left hand, the logarithm of each grasp's probability by all that is
    /// seen, in the order of the names, then that of none.
    by_side: [Vec<f64>; 2],
}

/// The powers of the neighbours' and of the networks' probabilities: all see the same hand, and are
/// sure of the same mistakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Powers {
    pub(super) neighbours: f64,
    pub(super) networks: f64,
}

/// The two networks' eyes on one picture.
pub(super) struct Eyes<'a> {
    pub(super) finding: Eye<'a>,
    pub(super) naming: Eye<'a>,
}

impl Prediction {
    /// What both networks see in a square that a hand stands upright in, as each of these hands;
    /// nothing is known of another one.
    pub(super) fn of_square(mut eyes: Eyes<'_>, square: &Square, sides: &[Side], powers: Powers) -> Self {
        let grasps = eyes.naming.network.grasps.clone();
        let [right, left] = [Side::Right, Side::Left].map(|side| match sides.contains(&side) {
            true => named(&mut eyes, square, side == Side::Left),
            false => Named { odds: 0.0, grasps: normalised(&vec![0.0; grasps.len() + 1]) },
        });
        let right_odds = (right.odds - left.odds) / sides.len().max(1) as f64;
        Self { right_odds, grasps, powers, by_side: [right.grasps, left.grasps] }
    }

    /// The probability that the hand is the other one than `side`.
    pub(crate) fn is_other_hand(&self, side: Side) -> f64 {
        let odds = if side == Side::Right { self.right_odds } else { -self.right_odds };
        1.0 / (1.0 + libm::exp(odds))
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

fn named(eyes: &mut Eyes<'_>, square: &Square, is_mirrored: bool) -> Named {
    let (mut odds, mut sum) = (0.0, Vec::new());
    for (eye, share) in [(&mut eyes.finding, FINDING), (&mut eyes.naming, 1.0 - FINDING)] {
        let grasps = eye.network.grasps.len();
        sum.resize(grasps + 1, 0.0);
        let share = share / LOOKS.len() as f64;
        for (turn, size) in LOOKS {
            let square = Square { turn: square.turn + turn, side: square.side * size, ..*square };
            let classes = eye.look(&square, is_mirrored).classes;
            let mirrored = classes[grasps];
            odds += share * (libm::log((-libm::expm1(mirrored)).max(LEAST)) - mirrored);
            let shown = classes[..grasps].iter().chain(&classes[grasps + 1..]);
            sum.iter_mut().zip(shown).for_each(|(sum, log)| *sum += share * log);
        }
    }
    Named { odds, grasps: normalised(&sum) }
}
