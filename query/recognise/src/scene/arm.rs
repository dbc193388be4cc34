//! Which hand it is, by where its arm comes from.
//!
//! Most pictures of a hand that holds something are taken from about where its person looks, with
//! the camera level: a right arm comes in from the right then, and a left one from the left. Where
//! a wearer's camera sees the hands, this alone tells them apart (Betancourt, Morerio, Barakova,
//! Marcenaro, Rauterberg and Regazzoni, "Left/right hand segmentation in egocentric videos",
//! Computer Vision and Image Understanding 154, 2017). A camera may stand elsewhere, so it counts
//! as one voice beside those of the networks.

/// How much likelier the hand of the side is that an arm comes from, level, as a logarithm. Chosen
/// on photographs and on pictures of two hands (docs/accuracy.md).
const FROM_THE_SIDE: f64 = 2.0;

/// The logarithm of how much likelier a right hand is than a left one, for a square that it stands
/// upright in.
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
    fn the_right_is_where_a_turned_square_has_its_lower_end() {
        let square = Square { centre: [50.0, 50.0], side: 40.0, turn: FRAC_PI_2 };
        let [x, y] = square.to_picture().apply([0.5, 1.0]);
        assert!((x - 70.0).abs() < 1e-9 && (y - 50.0).abs() < 1e-9, "{x} {y}");
    }
}
