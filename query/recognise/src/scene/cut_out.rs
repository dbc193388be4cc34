//! A hand that is cut out of its picture, as where its mask is given.

use super::find::upright;
use super::look::SquareInput;
use super::prediction::{Powers, Prediction};
use super::square::Square;
use crate::networks::Networks;
use crate::picture::Picture;
use crate::segment::Mask;
use crate::side::Side;
use grasp_index::{SHOWN_LENGTHS, end_of_hand};

/// The side of the square in which the grasp is named, in roots of the hand's area: the middle of
/// what the naming network was trained on.
const SIZES: f64 = 2.1;
/// How the networks join the neighbours: chosen on segmented pictures of two hands
/// (docs/trials.md); what is known of open hands helps one of them and harms the other.
const POWERS: Powers = Powers { neighbours: 0.8, networks: 0.8, opening: 0.0 };

impl Prediction {
    /// What the networks make of a hand that is cut out: `turn` radians clockwise turn it about
    /// upright, so that it is known roughly where the hand ends and the arm begins. It is looked at
    /// as each of `sides`. `None` where the mask is empty.
    pub fn of_cut_out(
        networks: &Networks,
        picture: &Picture,
        hand: &Mask,
        turn: f64,
        sides: &[Side],
    ) -> Option<Self> {
        let mut input = SquareInput::of_cut_out(picture, hand);
        let first = square(hand, turn, SIZES)?;
        let turn = upright(networks.finding(), &mut input, &first);
        let square = square(hand, turn, SIZES)?;
        Some(Self::of_square(networks, &mut input, &square, sides, POWERS))
    }
}

/// The square around a hand whose mask is turned upright by `turn` radians, its side `sizes` roots
/// of the hand's area; `None` where the mask is empty. What lies farther behind its uppermost point
/// than a descriptor is shown of it is arm, and does not count for where the hand is.
fn square(mask: &Mask, turn: f64, sizes: f64) -> Option<Square> {
    let (sin, cos) = libm::sincos(turn);
    let width = mask.width();
    let inside = || {
        let inside = mask.pixels().iter().enumerate().filter(|(_, inside)| **inside != 0);
        inside.map(|(at, _)| [at % width, at / width].map(|v| v as f64 + 0.5))
    };
    let end = end_of_hand(inside(), turn, SHOWN_LENGTHS);
    let hand = inside().filter(|[x, y]| sin * x + cos * y < end);
    let [x, y, area] = hand.fold([0.0; 3], |sum, [x, y]| [sum[0] + x, sum[1] + y, sum[2] + 1.0]);
    (area > 0.0).then(|| Square { centre: [x / area, y / area], side: sizes * area.sqrt(), turn })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_does_not_count_for_where_the_hand_is() {
        // A hand of 20 by 20 pixels, the arm below it as broad as half of it.
        let mask = |arm: usize| {
            let pixels = (0..100 * 100).map(|at| (at % 100, at / 100)).map(|(x, y)| {
                let is_hand = (40..60).contains(&x) && (10..30).contains(&y);
                let is_arm = (45..55).contains(&x) && (30..30 + arm).contains(&y);
                u8::from(is_hand || is_arm)
            });
            Mask::from_values(100, 100, &pixels.collect::<Vec<_>>(), |value| value > 0)
        };
        let [short, long, longer] = [0, 30, 60].map(|arm| square(&mask(arm), 0.0, 2.0).unwrap());
        assert_eq!(short, Square { centre: [50.0, 20.0], side: 40.0, turn: 0.0 });
        assert_eq!(long, longer);
        assert!(long.centre[1] > 20.0 && long.centre[1] < 26.0, "{long:?}");
        assert!(square(&Mask::from_values(4, 4, &[0u8; 16], |value| value > 0), 0.0, 2.0).is_none());
    }

    #[test]
    fn a_hand_that_is_turned_has_the_same_square() {
        let mask = |is_turned: bool| {
            let pixels = (0..80 * 80).map(|at| (at % 80, at / 80)).map(|(x, y)| {
                let (x, y) = if is_turned { (79 - y, x) } else { (x, y) };
                u8::from((30..44).contains(&x) && (5..75).contains(&y))
            });
            Mask::from_values(80, 80, &pixels.collect::<Vec<_>>(), |value| value > 0)
        };
        let upright = square(&mask(false), 0.0, 2.1).unwrap();
        // What was turned by a quarter anticlockwise is turned back.
        let turned = square(&mask(true), std::f64::consts::FRAC_PI_2, 2.1).unwrap();
        assert!((upright.side - turned.side).abs() < 1e-9);
        assert!((upright.centre[1] - turned.centre[0]).abs() < 1e-9, "{upright:?} {turned:?}");
    }
}
