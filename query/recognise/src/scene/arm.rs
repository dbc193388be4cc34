//! Which hand it is, by where its arm comes from.
//!
//! Most pictures of a hand that holds something are taken from about where its person looks, with
//! the camera level: a right arm comes in from the right then, and a left one from the left. In
//! egocentric videos hands are told apart by their angle and place (Betancourt, Morerio, Barakova,
//! Marcenaro, Rauterberg and Regazzoni, "Left/right hand segmentation in egocentric videos",
//! Computer Vision and Image Understanding 154, 2017). A camera may stand elsewhere, so the arm is
//! one voice beside those of the networks.

/// How much likelier the hand of the side is that an arm comes from, level, as a logarithm. Chosen
/// on photographs and on pictures of two hands (docs/trials.md).
const FROM_THE_SIDE: f64 = 3.0;

/// The logarithm of how much likelier a right hand is than a left one that stands upright in a
/// square of this turn, in radians.
pub(super) fn right_odds(turn: f64) -> f64 {
    // What is below in the square is to the right in the picture by so much.
    FROM_THE_SIDE * libm::sin(turn)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::super::square::Square;
    use super::*;

    #[test]
    fn an_arm_from_the_right_is_a_right_hands_and_one_from_below_or_above_anyones() {
        assert_eq!(right_odds(FRAC_PI_2), FROM_THE_SIDE);
        assert_eq!(right_odds(-FRAC_PI_2), -FROM_THE_SIDE);
        assert!(right_odds(0.0).abs() < 1e-9 && right_odds(PI).abs() < 1e-9);
    }

    #[test]
    fn the_side_is_where_the_squares_lower_end_is_in_the_picture() {
        for step in -12..=12 {
            let turn = f64::from(step) * PI / 12.0;
            let square = Square { centre: [50.0, 50.0], side: 2.0, turn };
            let [x, _] = square.to_picture().apply([0.5, 1.0]);
            assert!((right_odds(turn) - FROM_THE_SIDE * (x - 50.0)).abs() < 1e-9, "{turn}: {x}");
        }
    }
}
