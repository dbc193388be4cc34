//! From a picture to its hand: where it is, which it is, and what it holds it by.

use std::f64::consts::{FRAC_PI_2, TAU};

#[cfg(feature = "landmarks")]
use super::joints::{HandJoints, Seeker};
use super::landmarks::Joints;
use super::look::SquareInput;
use super::masks::{Masks, Part};
use super::patch::Patch;
use super::square::Square;
#[cfg(feature = "landmarks")]
use crate::mediapipe::{HandNetworks, HandNetworksError};
use crate::networks::{Networks, SceneNetwork};
use crate::picture::Picture;
use crate::segment::Mask;

/// The side of the square around a hand and what it holds, in roots of their area, while it is
/// looked for, and where the grasp is named: the middle of what the network was trained on.
const SIZES: f64 = 2.5;
const NAMED_SIZES: f64 = 2.1;
/// The side of the square around what is held, in roots of its area, and the least, in roots of the
/// hand's: the middle of what the network was trained on.
const THING_SIZES: f64 = 2.0;
const LEAST_OF_HAND: f64 = 0.9;
/// That of the first square, of the hand alone: not all of it may have been found. Its least side
/// is a share of the picture's shorter one: what hides most of a hand is seen as well.
const FIRST_SIZES: f64 = 3.0;
const FIRST_LEAST: f64 = 0.8;
/// Parts of a picture that are looked at where no hand is found in the whole: their sides, and how
/// far they are apart, in shares of the shorter side.
const TILE: f64 = 0.6;
const TILE_STEP: f64 = 0.3;
/// The most of them along a side, the first not counted: a picture that is hardly more than a line
/// shows no hand.
const MOST_TILES: f64 = 6.0;
/// The least share of a square that a hand has.
const LEAST: f64 = 0.004;
/// How often a square is fitted to hand and object.
const FITS: usize = 2;
/// A fit that leaves less than this share of the hand's area has lost the hand.
const LOST: f64 = 0.35;
/// Turns that are tried to see where the arm comes from.
const TURNS: usize = 6;
/// How much a forearm counts for that, beside all these looks together, for a share of the hand's
/// area of 1; and the most that it counts.
const FOREARM: f64 = 25.0;
const MOST_FOREARM: f64 = 8.0;
/// How much the turn of the frame before counts where a hand is followed, beside what the network
/// says now, which counts 1, and the forearm.
const INERTIA: f64 = 1.0;
/// A hand whose area is less than this share of that of the frame before, or more than its inverse,
/// is another, or is lost.
const SAME: f64 = 0.5;
/// One pixel in so many, along each side, is asked about.
const AGREE_STEP: usize = 3;
/// Log-odds of the masks beyond this say no more.
const MOST_SURE: f32 = 3.0;

/// A hand that was found, and what it holds, by networks' masks.
#[derive(Clone, Debug)]
pub struct Detection {
    /// What the mask network sees in the square that the scene network has found.
    masks: Masks,
    /// What the scene network has seen there: the hand is followed by that.
    coarse: Masks,
    /// Where its joints are, if that was known before.
    joints: Option<Joints>,
    /// The logarithm of how much likelier a right hand is than a left one, by what else has seen
    /// it.
    pub(super) right_odds: f64,
}

/// Finds the hand in a picture; `None` where the scene network sees none.
pub fn find(networks: &Networks, picture: &Picture) -> Option<Detection> {
    let (network, mut input) = (networks.finding(), SquareInput::new(picture));
    let (whole, patch) = first_patch(network, &mut input)?;
    let least = FIRST_LEAST * picture.width().min(picture.height()) as f64;
    let side = (FIRST_SIZES * patch.area.sqrt() * whole.side).max(least);
    let mut square = Square { centre: whole.to_picture().apply(patch.centre), side, turn: 0.0 };
    square.turn = upright(network, &mut input, &square);
    let masks = fitted(network, &mut input, square);
    Some(Detection::new(networks, &mut input, masks))
}

/// The hand whose joints were found by something else, and what it holds.
pub fn find_at(networks: &Networks, picture: &Picture, joints: &Joints) -> Detection {
    let (network, mut input) = (networks.finding(), SquareInput::new(picture));
    let (mut square, is_upright) = joints.square();
    if !is_upright {
        square.turn = upright(network, &mut input, &square);
    }
    let masks = fitted(network, &mut input, square);
    Detection { joints: Some(joints.clone()), ..Detection::new(networks, &mut input, masks) }
}

/// The hand whose joints MediaPipe's networks find, in the picture or where the scene network finds
/// a hand, and what it holds; `None` where they find none.
///
/// # Errors
/// Where the networks cannot be run.
#[cfg(feature = "landmarks")]
pub fn find_by_joints(
    hand_networks: &HandNetworks,
    networks: &Networks,
    picture: &Picture,
) -> Result<Option<Detection>, HandNetworksError> {
    let mut seeker = Seeker::new(hand_networks, picture);
    let mut seen = seeker.in_picture()?;
    if seen.is_none()
        && let Some(found) = find(networks, picture)
    {
        seen = seeker.about(&found.square())?;
    }
    Ok(seen.map(|HandJoints { joints, right_odds, .. }| Detection {
        right_odds,
        ..find_at(networks, picture, &joints)
    }))
}

/// The hand that was found in the frame before this one, where it is still about there; `None`
/// where it is not, or another is larger by now: [`find`] has to look for it then.
///
/// A look at the whole picture and two at the hand's square take the place of the ten or more that
/// [`find`] needs: where the arm comes from is known, and only how it has turned since is looked
/// at.
pub fn follow(networks: &Networks, picture: &Picture, before: &Detection) -> Option<Detection> {
    let (network, mut input) = (networks.finding(), SquareInput::new(picture));
    let (square, area) = (before.masks.square, before.coarse.hand_area());
    let whole = Masks::of_square(network, &mut input, Square::around(picture));
    if let Some(largest) = whole.largest_patch(Part::Hand).filter(|p| p.area > LEAST) {
        let place = square.from_picture().apply(whole.square.to_picture().apply(largest.centre));
        if !place.iter().all(|share| (0.0..1.0).contains(share)) {
            return None;
        }
    }
    let heads = input.run_on(network, &square);
    let mut direction = Direction::default();
    direction.add(square.turn, INERTIA);
    direction.add(square.turn + FRAC_PI_2 - heads.arm(), 1.0);
    let seen = Masks::new(picture, square, heads);
    if let Some((turn, share)) = turn_of_forearm(&seen) {
        direction.add(turn, share);
    }
    let is_still_there = |masks: &Masks| (SAME..1.0 / SAME).contains(&(masks.hand_area() / area));
    let fitted = seen.fitted(SIZES).filter(|_| is_still_there(&seen))?;
    let masks = Masks::of_square(network, &mut input, Square { turn: direction.turn(), ..fitted });
    is_still_there(&masks).then(|| Detection::new(networks, &mut input, masks))
}

/// What is seen in a square once it fits the hand in it.
fn fitted(network: &SceneNetwork, input: &mut SquareInput<'_>, square: Square) -> Masks {
    let mut masks = Masks::of_square(network, input, square);
    for _ in 0..FITS {
        let Some(fitted) = masks.fitted(SIZES) else { break };
        let found = Masks::of_square(network, input, fitted);
        if found.hand_area() < LOST * masks.hand_area() {
            break;
        }
        masks = found;
    }
    masks
}

/// The turn by which the arm comes from below: the mean of what the network says at several turns,
/// which counts the more the nearer to upright it is said at, and of where the forearm lies.
pub(super) fn upright(network: &SceneNetwork, input: &mut SquareInput<'_>, square: &Square) -> f64 {
    let mut direction = Direction::default();
    for step in 0..TURNS {
        let turn = TAU * step as f64 / TURNS as f64;
        let turned = Square { turn, ..*square };
        let heads = input.run_on(network, &turned);
        let arm = heads.arm();
        let upright = (0.5 + 0.5 * libm::cos(arm - FRAC_PI_2)).powi(2);
        direction.add(turn + FRAC_PI_2 - arm, upright);
        if let Some((turn, share)) = turn_of_forearm(&Masks::new(input.picture, turned, heads)) {
            direction.add(turn, share / TURNS as f64);
        }
    }
    direction.turn()
}

/// The turn by which the forearm that is seen comes from below, and how much that counts.
fn turn_of_forearm(masks: &Masks) -> Option<(f64, f64)> {
    let [hand, forearm] = [Part::Hand, Part::Forearm].map(|part| masks.largest_patch(part));
    let (hand, forearm) = (hand?, forearm?);
    let [x, y] = [0, 1].map(|i| forearm.centre[i] - hand.centre[i]);
    let share = (FOREARM * forearm.area / hand.area).min(MOST_FOREARM);
    Some((masks.square.turn + FRAC_PI_2 - libm::atan2(y, x), share))
}

/// A mean of turns.
#[derive(Default)]
struct Direction([f64; 2]);

impl Direction {
    fn add(&mut self, turn: f64, weight: f64) {
        let (sin, cos) = libm::sincos(turn);
        self.0 = [self.0[0] + weight * cos, self.0[1] + weight * sin];
    }

    fn turn(&self) -> f64 {
        libm::atan2(self.0[1], self.0[0])
    }
}

/// The largest patch of a hand in the whole picture, or in that part of it in which most of one is
/// seen; with the square that it was seen in.
fn first_patch(network: &SceneNetwork, input: &mut SquareInput<'_>) -> Option<(Square, Patch)> {
    let whole = Square::around(input.picture);
    let mut seen = |square: Square| {
        let masks = Masks::of_square(network, input, square);
        let patch = masks.largest_patch(Part::Hand)?;
        (patch.area > LEAST).then_some((square, patch))
    };
    if let Some(found) = seen(whole) {
        return Some(found);
    }
    let [width, height] = whole.centre.map(|half| 2.0 * half);
    let short = width.min(height);
    let places = |length: f64| {
        let (first, step) = (0.5 * TILE * short, TILE_STEP * short);
        let count = ((length - 2.0 * first) / step).round().clamp(0.0, MOST_TILES);
        (0..=count as usize).map(move |at| first + (length - 2.0 * first) * at as f64 / count.max(1.0))
    };
    let squares = places(height)
        .flat_map(|y| places(width).map(move |x| Square { centre: [x, y], side: TILE * short, turn: 0.0 }));
    squares.filter_map(seen).max_by(|a, b| a.1.area.total_cmp(&b.1.area))
}

impl Detection {
    /// What the scene network has found in a square, which the mask network then looks at.
    fn new(networks: &Networks, input: &mut SquareInput<'_>, coarse: Masks) -> Self {
        let masks = Masks::of_square(networks.cutting(), input, coarse.square);
        Self { masks, coarse, joints: None, right_odds: 0.0 }
    }

    /// The square that the hand stands upright in.
    pub fn square(&self) -> Square {
        self.masks.square
    }

    /// The square in which the grasp of the hand is named, whose mask on the same picture is known.
    pub(super) fn square_of(&self, hand: &Mask) -> Square {
        self.masks.fitted_to(hand, NAMED_SIZES).unwrap_or(self.masks.square)
    }

    /// The squares in which what the hand holds is looked at, one by each network's mask in which
    /// something is seen of it.
    pub(super) fn squares_of_thing(&self) -> Vec<Square> {
        let square =
            |masks: &Masks| masks.around_object(THING_SIZES, LEAST_OF_HAND * masks.hand_area().sqrt());
        [&self.masks, &self.coarse].into_iter().filter_map(square).collect()
    }

    /// The log-odds of a hand or its forearm at a place of the picture that was looked at, in
    /// pixels.
    pub(crate) fn skin(&self, place: [f64; 2]) -> f32 {
        let [hand, forearm] = self.masks.at([Part::Hand, Part::Forearm], place).unwrap_or([-MOST_SURE; 2]);
        let seen = hand.max(forearm).clamp(-MOST_SURE, MOST_SURE);
        seen + self.joints.as_ref().map_or(0.0, |joints| joints.hand(place))
    }

    /// The share of what the network or a mask of the picture takes for hand and forearm that both
    /// do, 0 to 1.
    pub fn agreement(&self, skin: &Mask) -> f64 {
        let (mut both, mut either) = (0usize, 0usize);
        for y in (0..skin.height()).step_by(AGREE_STEP) {
            for x in (0..skin.width()).step_by(AGREE_STEP) {
                let seen = self.skin([x as f64 + 0.5, y as f64 + 0.5]) > 0.0;
                both += usize::from(seen && skin.get(x, y));
                either += usize::from(seen || skin.get(x, y));
            }
        }
        both as f64 / either.max(1) as f64
    }
}
