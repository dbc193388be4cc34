//! [`Scene`]: all that the networks see in a camera picture.

use super::arm;
use super::find::Detection;
use super::look::SquareInput;
use super::prediction::{Powers, Prediction};
use super::square::Square;
use crate::networks::Networks;
use crate::picture::Picture;
use crate::segment::Mask;
use crate::side::Side;

/// How the networks join the neighbours: chosen on camera pictures of two hands (docs/trials.md).
const POWERS: Powers = Powers { neighbours: 0.72, networks: 1.2, opening: 1.0 };

/// What the networks see in a camera picture.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where the hand was found.
    pub found: Detection,
    /// The square in which it was looked at in the end.
    pub square: Square,
    /// Which hand it is, and what it does.
    pub prediction: Prediction,
}

impl Scene {
    /// Looks at a hand, whose mask was found on the same picture, as a right one and as a left one.
    pub fn new(networks: &Networks, picture: &Picture, found: Detection, hand: &Mask) -> Self {
        let square = found.square_of(hand);
        let sides = [Side::Right, Side::Left];
        let mut input = SquareInput::new(picture);
        let mut prediction = Prediction::of_square(networks, &mut input, &square, &sides, POWERS);
        prediction.add_cut_out(networks, &mut SquareInput::of_cut_out(picture, hand), &square, &sides);
        prediction.add_thing(networks, &mut input, &found.squares_of_thing(), &sides);
        prediction.right_odds += found.right_odds;
        prediction.arm_odds = arm::right_odds(square.turn);
        Self { found, square, prediction }
    }
}
