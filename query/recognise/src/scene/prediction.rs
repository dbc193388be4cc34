//! Which hand it is and what it does, by looks of networks at it.

use grasp_index::from_columns;
use nalgebra::UnitQuaternion;

use super::look::SquareInput;
use super::square::Square;
use crate::networks::{GRASP, Heads, Networks, STAGES, SceneNetwork, normalised};
use crate::orientation::in_picture;
use crate::side::Side;

/// Looks at a hand: turned and enlarged by so much.
const LOOKS: [(f64, f64); 3] = [(0.0, 1.0), (0.22, 1.12), (-0.22, 0.92)];
/// How much the network counts that finds hands; the rest is that of the network that has learned
/// to name them. Chosen on pictures of two hands (docs/trials.md).
const FINDING: f64 = 0.4;
/// How much the grasp counts that both see in a look at the hand alone, all else black; the rest is
/// that of the looks at the picture. Chosen on pictures of two hands before other backgrounds
/// (docs/trials.md).
const CUT_OUT: f64 = 0.3;
/// How much the network counts beside both that looks at what is held: of the stage, and of the
/// grasp where the thing is held for certain.
const THING_OF_STAGE: f64 = 0.4;
const THING_OF_GRASP: f64 = 0.9;
/// How far the networks' logarithm of odds of the hand is taken at its word where both hands'
/// grasps are joined by it.
const SIDE_AT_ITS_WORD: f64 = 0.5;
/// The least probability that is divided by.
const LEAST: f64 = 1e-6;

/// Which hand it is, and what it does, by what the networks see.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The logarithm of how much likelier a right hand is than a left one, by what networks see.
    pub right_odds: f64,
    /// The same by where its arm comes from.
    pub(super) arm_odds: f64,
    /// The grasps' names.
    pub(super) grasps: Vec<String>,
    /// How it joins what the neighbours say.
    pub(super) powers: Powers,
    /// For a right and for a left hand, the logarithm of each grasp's probability by all that is
    /// seen, in the order of the names, then that of none.
    by_side: [Vec<f64>; 2],
    /// For each hand, the logarithm of the probability of each stage, up to a constant.
    stages_by_side: [[f64; STAGES]; 2],
    /// For each hand, its `camera_from_hand` in the picture by each look of the naming network.
    rotations_by_side: [Vec<UnitQuaternion<f64>>; 2],
}

/// The powers of the neighbours' and of the networks' probabilities (all see the same hand, and are
/// sure of the same mistakes), and what is added to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Powers {
    pub(super) neighbours: f64,
    pub(super) networks: f64,
    /// How much it counts that hands look different before they hold something, 0 to 1: see
    /// [`super::Opening`].
    pub(super) opening: f64,
}

impl Prediction {
    /// What the scene and the naming network see in a square that a hand stands upright in, as each
    /// of these hands; nothing is known of another one.
    pub(super) fn of_square(
        networks: &Networks,
        input: &mut SquareInput<'_>,
        square: &Square,
        sides: &[Side],
        powers: Powers,
    ) -> Self {
        let mut seen = looks(input, &[*square], &LOOKS, sides, &naming_networks(networks));
        let right_odds = (seen[0].odds - seen[1].odds) / sides.len().max(1) as f64;
        let stages_by_side = [0, 1].map(|side| seen[side].stages);
        let rotations_by_side = [0, 1].map(|side| std::mem::take(&mut seen[side].rotations));
        let by_side = seen.map(|seen| normalised(&seen.grasps));
        let grasps = networks.naming().grasps.clone();
        Self { right_odds, arm_odds: 0.0, grasps, powers, by_side, stages_by_side, rotations_by_side }
    }

    /// Joins what the scene and the naming network see of the grasp in the same square of the hand
    /// cut out ([`SquareInput::of_cut_out`]): backgrounds differ from those that they have learned
    /// from, black does not.
    pub(super) fn add_cut_out(
        &mut self,
        networks: &Networks,
        input: &mut SquareInput<'_>,
        square: &Square,
        sides: &[Side],
    ) {
        let seen = looks(input, &[*square], &LOOKS[..1], sides, &naming_networks(networks));
        for (logs, seen) in self.by_side.iter_mut().zip(seen) {
            let seen = normalised(&seen.grasps);
            logs.iter_mut().zip(seen).for_each(|(log, seen)| *log += CUT_OUT * (seen - *log));
            *logs = normalised(logs);
        }
    }

    /// Joins what is seen in squares around what the hand holds, the more the likelier it is that
    /// the hand holds something; their mean, where there are several, and nothing where there is
    /// none.
    pub(super) fn add_thing(
        &mut self,
        networks: &Networks,
        input: &mut SquareInput<'_>,
        squares: &[Square],
        sides: &[Side],
    ) {
        let things =
            WeightedNetwork { network: networks.things(), share: 1.0, is_asked_for_rotations: false };
        let seen = looks(input, squares, &LOOKS, sides, &[things]);
        for ((logs, stages), seen) in self.by_side.iter_mut().zip(&mut self.stages_by_side).zip(seen) {
            stages.iter_mut().zip(seen.stages).for_each(|(log, seen)| *log += THING_OF_STAGE * seen);
            let share = THING_OF_GRASP * libm::exp(normalised(stages)[GRASP]);
            logs.iter_mut().zip(seen.grasps).for_each(|(log, seen)| *log += share * seen);
            *logs = normalised(logs);
        }
    }

    /// The probability that the hand is the other one than `side`.
    pub(crate) fn probability_of_other_hand(&self, side: Side) -> f64 {
        let right = self.right_odds + self.arm_odds;
        1.0 / (1.0 + libm::exp(if side == Side::Right { right } else { -right }))
    }

    /// How likely the stages reach, close and grasp are if the hand is this one.
    pub fn stages(&self, side: Side) -> [f64; STAGES] {
        let logs = normalised(&self.stages_by_side[usize::from(side == Side::Left)]);
        std::array::from_fn(|stage| libm::exp(logs[stage]))
    }

    /// `camera_from_hand` in the picture if the hand is this one, by each look of the naming
    /// network.
    pub(crate) fn rotations(&self, side: Side) -> &[UnitQuaternion<f64>] {
        &self.rotations_by_side[usize::from(side == Side::Left)]
    }

    /// How likely each grasp is if the hand is this one, in the order of the network's names; then
    /// how likely it is in none of them. The probabilities sum to 1.
    pub fn probabilities(&self, side: Side) -> Vec<f64> {
        let logs = &self.by_side[usize::from(side == Side::Left)];
        logs.iter().copied().map(libm::exp).collect()
    }

    /// The same of a hand that is taken for this one but might be the other: the mean of what both
    /// would be, by how likely the networks find each, this one at least as likely.
    pub(crate) fn probabilities_of_likelier(&self, side: Side) -> Vec<f64> {
        let odds = if side == Side::Right { self.right_odds } else { -self.right_odds };
        let other = 1.0 / (1.0 + libm::exp((SIDE_AT_ITS_WORD * odds).max(0.0)));
        let sides = self.probabilities(side).into_iter().zip(self.probabilities(side.other()));
        sides.map(|(this, that)| this + other * (that - this)).collect()
    }
}

/// A network that looks at a hand.
struct WeightedNetwork<'n> {
    network: &'n SceneNetwork,
    /// How much it counts.
    share: f64,
    /// Whether it is asked how the hand is turned.
    is_asked_for_rotations: bool,
}

/// The networks that name the grasp of a hand. The naming network alone is asked how it is turned:
/// the scene network's rotation makes the answer's orientation no better (docs/trials.md).
fn naming_networks(networks: &Networks) -> [WeightedNetwork<'_>; 2] {
    [
        WeightedNetwork { network: networks.finding(), share: FINDING, is_asked_for_rotations: false },
        WeightedNetwork { network: networks.naming(), share: 1.0 - FINDING, is_asked_for_rotations: true },
    ]
}

/// What networks see in squares of a right and of a left hand, where these are asked about, each
/// square turned and enlarged in some ways: the mean of all looks.
fn looks(
    input: &mut SquareInput<'_>,
    squares: &[Square],
    ways: &[(f64, f64)],
    sides: &[Side],
    networks: &[WeightedNetwork<'_>],
) -> [MeanOfLooks; 2] {
    let grasps = networks.first().map_or(0, |weighted| weighted.network.grasps.len());
    let mut means = [MeanOfLooks::new(grasps), MeanOfLooks::new(grasps)];
    let looks = squares.iter().flat_map(|square| ways.iter().map(move |way| (square, way)));
    let share_of_look = 1.0 / (squares.len() * ways.len()) as f64;
    for (square, &(turn, size)) in looks {
        for (side, mean) in [Side::Right, Side::Left].into_iter().zip(&mut means) {
            if !sides.contains(&side) {
                continue;
            }
            // A left hand is looked at as its mirror image would be, turned the other way.
            let turn = if side == Side::Left { -turn } else { turn };
            let square = Square { turn: square.turn + turn, side: square.side * size, ..*square };
            input.sample(&square);
            if side == Side::Left {
                input.mirror();
            }
            for weighted in networks {
                let heads = input.run(weighted.network);
                mean.add(&heads, weighted.share * share_of_look);
                if weighted.is_asked_for_rotations {
                    mean.rotations.extend(rotation(&heads, &square, side));
                }
            }
        }
    }
    means
}

/// How a hand is turned in the picture, by what is seen of it in a square, flipped for a left hand.
fn rotation(heads: &Heads, square: &Square, side: Side) -> Option<UnitQuaternion<f64>> {
    let seen = from_columns(heads.rotation.map(|value| value as f32))?;
    let turned_deg = square.turn.to_degrees();
    Some(in_picture(side, if side == Side::Left { -turned_deg } else { turned_deg }, &seen))
}

/// The mean of what several looks at one of both hands say; without any, all is as likely.
struct MeanOfLooks {
    /// The log-odds of its being that hand.
    odds: f64,
    /// The logarithm of each grasp's probability, then that of none, up to the same constant.
    grasps: Vec<f64>,
    /// The same of each stage.
    stages: [f64; STAGES],
    /// `camera_from_hand` in the picture, by each look of a network that is asked for it.
    rotations: Vec<UnitQuaternion<f64>>,
}

impl MeanOfLooks {
    fn new(grasps: usize) -> Self {
        Self { odds: 0.0, grasps: vec![0.0; grasps + 1], stages: [0.0; STAGES], rotations: Vec::new() }
    }

    /// Counts one look more.
    fn add(&mut self, heads: &Heads, share: f64) {
        self.odds += share * (libm::log((-libm::expm1(heads.mirrored)).max(LEAST)) - heads.mirrored);
        self.grasps.iter_mut().zip(&heads.classes).for_each(|(sum, log)| *sum += share * log);
        let stages = normalised(&heads.stages);
        self.stages.iter_mut().zip(stages).for_each(|(sum, log)| *sum += share * log);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;
    use crate::segment::Mask;
    use grasp_index::{mirror_orientation, turned_orientation};

    const SQUARE: Square = Square { centre: [32.0, 32.0], side: 60.0, turn: 0.2 };
    const POWERS: Powers = Powers { neighbours: 1.0, networks: 1.0, opening: 0.0 };

    /// A picture of 64 x 64 pixels of many shades.
    fn shaded() -> Picture {
        let shade = |at: usize| [at % 64 * 3, at / 64 * 2, at % 7 * 9].map(|v| v as u8);
        Picture::new(64, 64, (0..64 * 64).map(shade).collect()).unwrap()
    }

    #[test]
    fn what_is_held_changes_the_grasps_of_the_hands_that_are_asked_about_and_not_which_hand_it_is() {
        let picture = shaded();
        let (networks, mut input) = (Networks::default(), SquareInput::new(&picture));
        let without = Prediction::of_square(&networks, &mut input, &SQUARE, &[Side::Right], POWERS);
        let mut with = without.clone();
        with.add_thing(&networks, &mut input, &[], &[Side::Right]);
        assert_eq!(with.probabilities(Side::Right), without.probabilities(Side::Right));
        with.add_thing(&networks, &mut input, &[Square { side: 30.0, ..SQUARE }], &[Side::Right]);
        assert_eq!(with.right_odds, without.right_odds);
        assert_ne!(with.probabilities(Side::Right), without.probabilities(Side::Right));
        for (is, was) in with.probabilities(Side::Left).iter().zip(without.probabilities(Side::Left)) {
            assert!((is - was).abs() < 1e-12, "{is} {was}");
        }
        for side in [Side::Right, Side::Left] {
            assert!((with.probabilities(side).iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_hand_is_turned_with_its_picture_and_a_left_one_is_seen_as_its_mirror_image() {
        let networks = Networks::default();
        // What is seen in the picture whose pixel (x, y) is the shaded one's at `of(x, y)`.
        let seen = |of: fn(usize, usize) -> (usize, usize), square: Square, side: Side| {
            let shaded = shaded();
            let pixel = |at: usize| of(at % 64, at / 64);
            let pixels = (0..64 * 64).map(pixel).map(|(x, y)| shaded.rgb()[64 * y + x]).collect();
            let picture = Picture::new(64, 64, pixels).unwrap();
            let seen =
                Prediction::of_square(&networks, &mut SquareInput::new(&picture), &square, &[side], POWERS);
            assert_eq!([side, side.other()].map(|side| seen.rotations(side).len()), [LOOKS.len(), 0]);
            seen
        };
        let apart = |a: UnitQuaternion<f64>, b: UnitQuaternion<f64>| a.angle_to(&b).to_degrees();
        let square = Square { centre: [30.0, 36.0], ..SQUARE };
        let own = seen(|x, y| (x, y), square, Side::Right);
        let mirrored = Square { centre: [64.0 - 30.0, 36.0], turn: -square.turn, ..square };
        let left = seen(|x, y| (63 - x, y), mirrored, Side::Left);
        // Every look, also those that are turned.
        for (left, own) in left.rotations(Side::Left).iter().zip(own.rotations(Side::Right)) {
            assert!(apart(*left, mirror_orientation(own)) < 1.0, "{}", apart(*left, mirror_orientation(own)));
        }
        for (left, own) in left.probabilities(Side::Left).iter().zip(own.probabilities(Side::Right)) {
            assert!((left - own).abs() < 0.02, "{left} {own}");
        }
        assert!((left.right_odds + own.right_odds).abs() < 0.1, "{} {}", left.right_odds, own.right_odds);
        // A quarter turn clockwise.
        let quarter = std::f64::consts::FRAC_PI_2;
        let turned = Square { centre: [64.0 - 36.0, 30.0], turn: square.turn - quarter, ..square };
        let turned = seen(|x, y| (y, 63 - x), turned, Side::Right).rotations(Side::Right)[0];
        let expected = turned_orientation(90.0, &own.rotations(Side::Right)[0]);
        assert!(apart(turned, expected) < 1.0, "{}", apart(turned, expected));
    }

    #[test]
    fn a_hand_that_is_cut_out_changes_its_grasps_and_not_which_hand_it_is() {
        let picture = shaded();
        let places: Vec<usize> = (0..64 * 64).collect();
        let hand = Mask::from_values(64, 64, &places, |at| (16..48).contains(&(at % 64)) && at / 64 > 20);
        let (networks, mut input) = (Networks::default(), SquareInput::of_cut_out(&picture, &hand));
        let before = Prediction::of_square(
            &networks,
            &mut SquareInput::new(&picture),
            &SQUARE,
            &[Side::Right],
            POWERS,
        );
        let mut joined = before.clone();
        joined.add_cut_out(&networks, &mut input, &SQUARE, &[Side::Right]);
        assert_eq!((joined.right_odds, joined.stages_by_side), (before.right_odds, before.stages_by_side));
        assert_ne!(joined.probabilities(Side::Right), before.probabilities(Side::Right));
        for (is, was) in joined.probabilities(Side::Left).iter().zip(before.probabilities(Side::Left)) {
            assert!((is - was).abs() < 1e-12, "{is} {was}");
        }
        assert!((joined.probabilities(Side::Right).iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    /// A hand that is a pinch if it is a right one, and a lid's if it is a left one.
    fn of_odds(right_odds: f64) -> Prediction {
        Prediction {
            right_odds,
            arm_odds: 0.0,
            grasps: vec!["pinch".to_owned(), "precision-disc".to_owned()],
            powers: POWERS,
            by_side: [[0.8, 0.1, 0.1], [0.2, 0.7, 0.1]].map(|of| of.map(libm::log).to_vec()),
            stages_by_side: [[0.0; STAGES]; 2],
            rotations_by_side: Default::default(),
        }
    }

    #[test]
    fn a_hand_that_might_be_the_other_one_does_what_both_would() {
        let pinch = |odds: f64, side: Side| of_odds(odds).probabilities_of_likelier(side)[0];
        assert!((pinch(60.0, Side::Right) - 0.8).abs() < 1e-9);
        assert!((pinch(0.0, Side::Right) - 0.5).abs() < 1e-9);
        // A hand that is known by its arm counts for half at least, whatever the networks see.
        assert!((pinch(-60.0, Side::Right) - 0.5).abs() < 1e-9);
        assert!((pinch(-60.0, Side::Left) - 0.2).abs() < 1e-9);
        assert!(pinch(3.0, Side::Right) > pinch(1.0, Side::Right));
        let sum: f64 = of_odds(1.0).probabilities_of_likelier(Side::Left).iter().sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_arm_settles_which_hand_it_is_where_networks_do_not_know_and_not_where_they_do() {
        let right = |right_odds: f64| Prediction { arm_odds: 3.0, ..of_odds(right_odds) };
        assert!(
            right(0.0).probability_of_other_hand(Side::Right) < 0.2
                && right(0.0).probability_of_other_hand(Side::Left) > 0.8
        );
        assert!(right(-6.0).probability_of_other_hand(Side::Right) > 0.8);
    }
}
