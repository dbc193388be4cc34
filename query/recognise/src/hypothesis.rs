//! What the picture may show: a left or a right hand, turned about the optical axis.
//!
//! The index holds right hands. A left hand's picture is flipped; all are turned as the index's descriptors want it (upright, in
//! one of the preset `wide`), and besides by as many angles as are to be tried. The hypothesis whose neighbours are nearest is the answer, and its
//! orientation is turned and flipped back.

use grasp_index::{
    HandImage, Index, Neighbour, Search, SearchCost, SearchOptions, Vote, euler_deg, mirror_orientation,
};
use nalgebra::{UnitQuaternion, Vector3};

use super::{RecogniseError, RecogniseOptions, Side, Timings};

/// A hand, a roll, and what the index says to them.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Which hand.
    pub side: Side,
    /// How far the picture, flipped for a left hand, was turned to be recognised, in degrees clockwise, 0..360: to stand as the index's
    /// pictures do, and by the angle that was tried.
    pub roll_deg: f64,
    /// The hand image as it was described: flipped for a left hand, then turned.
    pub image: HandImage,
    /// Its descriptor.
    pub descriptor: Vec<f32>,
    /// The nearest entries, nearest first.
    pub neighbours: Vec<Neighbour>,
    /// What the search for these neighbours cost.
    pub cost: SearchCost,
    /// Classes and orientation; the orientation is that of the hand in the picture as it was given.
    pub vote: Vote,
    /// How many hypotheses were searched for, this one included.
    pub tried: usize,
    /// How much farther the neighbours of the other hand lie: 0 as far, 1 twice as far. `None` where it was not tried.
    pub rival: Option<f64>,
}

impl Hypothesis {
    /// The orientation that an entry's `camera_from_hand` means for the picture as it was given.
    pub fn in_picture(&self, entry: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        in_picture(self.side, self.roll_deg, entry)
    }

    /// The mean distance of the neighbours, larger the more the picture was turned by `tried_deg` besides; the smallest is the answer.
    fn unlikeliness(&self, tried_deg: f64) -> f64 {
        let tilt = tried_deg.min(360.0 - tried_deg) / 180.0;
        mean_distance(&self.neighbours) * (1.0 + TILT_PENALTY * tilt)
    }
}

/// How much larger the distance of a picture counts that was turned the other way up: cameras are mostly level, and an upright hand is
/// mostly found to be one.
const TILT_PENALTY: f64 = 0.2;

fn in_picture(side: Side, roll_deg: f64, entry: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let level = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -roll_deg.to_radians()) * entry;
    match side {
        Side::Right => level,
        Side::Left => mirror_orientation(&level),
    }
}

/// Tries every hand and roll of the options and returns the hypothesis whose neighbours are nearest.
pub(super) fn best(
    index: &Index,
    hand: &HandImage,
    options: &RecogniseOptions,
    timings: &mut Timings,
) -> Result<Hypothesis, RecogniseError> {
    let rolls = options.rolls.max(1);
    let first = options.hand.sides().first().copied().unwrap_or_default();
    let k = options.k.unwrap_or(index.catalogue().calibration.k as usize).max(1);
    let search = SearchOptions { k, effort: options.effort };
    let mut best: [Option<(f64, Hypothesis)>; 2] = [None, None];
    let mut describer = index.describer();
    let upright = timings.time(|t| &mut t.descriptor_ms, || index.catalogue().descriptor.turn_deg(hand));
    for turn in 0..rolls {
        let tried = turn as f64 / rolls as f64 * 360.0;
        let degrees = (upright + tried).rem_euclid(360.0);
        let turned = timings.time(|t| &mut t.descriptor_ms, || hand.rotated(degrees.to_radians()));
        for &side in options.hand.sides() {
            let (roll_deg, image, descriptor) = timings.time(
                |t| &mut t.descriptor_ms,
                || {
                    // Turning and then flipping is flipping and then turning the other way: one turn serves both hands.
                    let (roll_deg, image) = match side {
                        Side::Right => (degrees, turned.clone()),
                        Side::Left => ((360.0 - degrees) % 360.0, turned.mirrored()),
                    };
                    let descriptor = describer.describe_turned(&image);
                    (roll_deg, image, descriptor)
                },
            );
            let found = timings.time(|t| &mut t.search_ms, || index.search(&descriptor, &search))?;
            let vote = timings.time(|t| &mut t.vote_ms, || index.vote(&found.neighbours, &options.vote));
            let Search { neighbours, cost } = found;
            let hypothesis = Hypothesis {
                side,
                roll_deg,
                image,
                descriptor,
                neighbours,
                cost,
                vote,
                tried: 0,
                rival: None,
            };
            let distance = hypothesis.unlikeliness(tried);
            let [of_first, of_other] = &mut best;
            let of_side = if side == first { of_first } else { of_other };
            if of_side.as_ref().is_none_or(|(least, _)| distance < *least) {
                *of_side = Some((distance, hypothesis));
            }
        }
    }
    let (mut best, rival) = match best {
        // The first hand wins a tie.
        [Some((a, first)), Some((b, other))] => {
            let ((near, best), far) = if b < a { ((b, other), a) } else { ((a, first), b) };
            (best, Some(far / near.max(f64::MIN_POSITIVE) - 1.0))
        }
        [Some((_, only)), None] | [None, Some((_, only))] => (only, None),
        [None, None] => return Err(RecogniseError::NoHand),
    };
    best.rival = rival;
    best.tried = rolls * options.hand.sides().len();
    let rotation = best.in_picture(&best.vote.orientation.rotation);
    best.vote.orientation.euler_deg = euler_deg(&rotation);
    best.vote.orientation.rotation = rotation;
    Ok(best)
}

fn mean_distance(neighbours: &[Neighbour]) -> f64 {
    let sum: f64 = neighbours.iter().map(|neighbour| f64::from(neighbour.distance)).sum();
    sum / neighbours.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn turning_the_picture_turns_the_answer_back() {
        let seen = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0);
        // The hand as it was given, turned clockwise by 90 degrees, is what was recognised.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TAU / 4.0) * seen;
        assert!(in_picture(Side::Right, 90.0, &turned).angle_to(&seen) < 1e-9);
        let left = mirror_orientation(&seen);
        assert!(in_picture(Side::Left, 90.0, &turned).angle_to(&left) < 1e-9);
    }
}
