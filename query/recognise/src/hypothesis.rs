//! What the picture may show: a left or a right hand, turned about the optical axis.
//!
//! The index holds right hands. A left hand's picture is flipped; all are turned as the index's
//! descriptors want it (upright, in the presets `standard` and `wide`), and besides by as many
//! angles as are to be tried. The hypothesis whose neighbours are nearest, where networks do
//! not speak against it, is the answer, and its orientation is turned and flipped back.

use grasp_index::{
    Describer, HandImage, Index, Look, Neighbour, NetworkEstimate, Search, SearchCost, SearchOptions, Vote,
    VoteOptions, euler_deg,
};
use nalgebra::UnitQuaternion;

use super::orientation::in_picture;
use super::{HandChoice, RecogniseError, RecogniseOptions, Side, Timings};
use crate::scene::Prediction;

/// A hand, a roll, and what the index says to them.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Which hand.
    pub side: Side,
    /// How far the picture, flipped for a left hand, was turned to be recognised, in degrees
    /// clockwise, 0..360: to stand as the index's pictures do, and by the angle that was tried.
    pub roll_deg: f64,
    /// How far it was turned before a left hand's was flipped.
    turned_deg: f64,
    /// The descriptor of [`Self::described_image`].
    pub descriptor: Vec<f32>,
    /// The nearest entries, nearest first.
    pub neighbours: Vec<Neighbour>,
    /// What the search for these neighbours cost.
    pub cost: SearchCost,
    /// Classes and orientation; the orientation is that of the hand in the picture as it was given.
    pub vote: Vote,
    /// How many hypotheses were searched for, this one included.
    pub tried: usize,
    /// How much unlikelier the other hand is: 0 as likely; 1 as if its neighbours lay twice as far.
    /// `None` where it was not tried.
    pub rival: Option<f64>,
}

impl Hypothesis {
    /// The hand image as it was described: turned, and flipped for a left hand. `hand` is the one
    /// that was recognised.
    pub fn described_image(&self, hand: &HandImage) -> HandImage {
        of_side(self.side, hand.rotated(self.turned_deg.to_radians()))
    }

    /// The orientation that an entry's `camera_from_hand` means for the picture as it was given.
    pub fn in_picture(&self, entry: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        in_picture(self.side, self.roll_deg, entry)
    }
}

fn of_side(side: Side, turned: HandImage) -> HandImage {
    match side {
        Side::Right => turned,
        Side::Left => turned.mirrored(),
    }
}

/// A hand and a roll that are tried, before anything is voted on.
struct Candidate {
    side: Side,
    roll_deg: f64,
    turned_deg: f64,
    descriptor: Vec<f32>,
    found: Search,
    /// What the descriptor's network says of it by itself.
    opinion: Option<NetworkEstimate>,
}

impl Candidate {
    /// The mean distance of the neighbours, larger the more the picture was turned by `tried_deg`
    /// besides; the smallest is the answer. So it is where the descriptor's network takes the hand
    /// for the mirror image of a right one, and where the scene networks do.
    fn unlikeliness(&self, tried_deg: f64, prediction: Option<&Prediction>) -> f64 {
        let tilt = tried_deg.min(360.0 - tried_deg) / 180.0;
        let mirrored = self.opinion.as_ref().map(|opinion| opinion.mirrored);
        let other = prediction.map(|prediction| prediction.probability_of_other_hand(self.side));
        let mirrored =
            [mirrored, other].map(|probability| 1.0 + MIRROR_PENALTY * probability.unwrap_or_default());
        mean_distance(&self.found.neighbours) * (1.0 + TILT_PENALTY * tilt) * mirrored[0] * mirrored[1]
    }
}

/// How far beside upright a learned descriptor's picture is looked at besides, in degrees: as far
/// as hands that are held alike are found upright differently. On the development hands two more
/// looks are worth three to four points, and more of them nothing.
const LOOKS_DEG: [f64; 2] = [15.0, -15.0];

/// How much larger the distance of a picture counts that the network takes for a mirrored hand's
/// for certain. From 1 on, it hardly matters how large it is.
const MIRROR_PENALTY: f64 = 3.0;

/// How much larger the distance of a picture counts that was turned the other way up: cameras are
/// mostly level, and an upright hand is mostly found to be one.
const TILT_PENALTY: f64 = 0.2;

/// Tries every roll of the options, of one hand or of both, and returns the likeliest hypothesis:
/// that whose neighbours are nearest, where networks do not speak against it.
pub(super) fn best(
    index: &Index,
    hand: &HandImage,
    prediction: Option<&Prediction>,
    choice: HandChoice,
    options: &RecogniseOptions,
    timings: &mut Timings,
) -> Result<Hypothesis, RecogniseError> {
    let k = options.k.unwrap_or(index.search_options().k).max(1);
    let search = SearchOptions { k, effort: options.effort };
    let flipped = hand.mirrored();
    let mut tries = Tries { index, hand, flipped: &flipped, search, describer: index.describer(), timings };
    let rolls = options.rolls.max(1);
    let nearest = tries.nearest_of_sides(choice.sides(), rolls, prediction)?;
    let (best, rival) = likelier(nearest).ok_or(RecogniseError::NoHand)?;
    let mut vote = tries.vote(&best, &options.vote)?;
    let rotation = in_picture(best.side, best.roll_deg, &vote.orientation.rotation);
    vote.orientation.euler_deg = euler_deg(&rotation);
    vote.orientation.rotation = rotation;
    let Candidate { side, roll_deg, turned_deg, descriptor, found: Search { neighbours, cost }, .. } = best;
    let tried = rolls * choice.sides().len();
    Ok(Hypothesis { side, roll_deg, turned_deg, descriptor, neighbours, cost, vote, tried, rival })
}

/// A candidate and how unlikely it is.
type Scored = (f64, Candidate);

/// The likelier of two hands, of which the first wins a tie, and how much unlikelier the other is.
fn likelier(nearest: [Option<Scored>; 2]) -> Option<(Candidate, Option<f64>)> {
    match nearest {
        [Some((a, first)), Some((b, other))] => {
            let ((near, best), far) = if b < a { ((b, other), a) } else { ((a, first), b) };
            // Both at the same place, at no distance, are as likely.
            Some((best, Some(if far > near { far / near.max(f64::MIN_POSITIVE) - 1.0 } else { 0.0 })))
        }
        [Some((_, only)), None] | [None, Some((_, only))] => Some((only, None)),
        [None, None] => None,
    }
}

/// What all hypotheses about one picture are tried with.
struct Tries<'a> {
    index: &'a Index,
    hand: &'a HandImage,
    /// The same, flipped: a left hand as a right one.
    flipped: &'a HandImage,
    search: SearchOptions,
    describer: Describer,
    timings: &'a mut Timings,
}

impl<'a> Tries<'a> {
    fn hand_of(&self, side: Side) -> &'a HandImage {
        match side {
            Side::Right => self.hand,
            Side::Left => self.flipped,
        }
    }

    /// The least unlikely of the rolls of each of these hands, in their order.
    fn nearest_of_sides(
        &mut self,
        sides: &[Side],
        rolls: usize,
        prediction: Option<&Prediction>,
    ) -> Result<[Option<Scored>; 2], RecogniseError> {
        let descriptor = &self.index.catalogue().descriptor;
        let upright_deg = self.timings.time(|t| &mut t.descriptor_ms, || descriptor.turn_deg(self.hand));
        let mut nearest = [None, None];
        for roll in 0..rolls {
            let beside_deg = roll as f64 / rolls as f64 * 360.0;
            let turned_deg = (upright_deg + beside_deg).rem_euclid(360.0);
            // A network turns the picture itself.
            let turn = || (!descriptor.is_learned()).then(|| self.hand.rotated(turned_deg.to_radians()));
            let turned = self.timings.time(|t| &mut t.descriptor_ms, turn);
            for (&side, nearest) in sides.iter().zip(&mut nearest) {
                let candidate = self.candidate(side, turned_deg, turned.as_ref())?;
                let unlikeliness = candidate.unlikeliness(beside_deg, prediction);
                if nearest.as_ref().is_none_or(|(least, _)| unlikeliness < *least) {
                    *nearest = Some((unlikeliness, candidate));
                }
            }
        }
        Ok(nearest)
    }

    /// One hand in the picture turned by `turned_deg`; `turned` is that picture, where it was made.
    fn candidate(
        &mut self,
        side: Side,
        turned_deg: f64,
        turned: Option<&HandImage>,
    ) -> Result<Candidate, RecogniseError> {
        // Turning and then flipping is flipping and then turning the other way: one turn serves
        // both hands.
        let roll_deg = if side == Side::Left { (360.0 - turned_deg) % 360.0 } else { turned_deg };
        let hand = self.hand_of(side);
        let describe = || match turned {
            None => self.describer.describe_turned(hand, roll_deg, self.hand),
            Some(turned) => self.describer.describe_turned(hand, roll_deg, &of_side(side, turned.clone())),
        };
        let descriptor = self.timings.time(|t| &mut t.descriptor_ms, describe);
        let (found, opinion) = self.found(&descriptor)?;
        Ok(Candidate { side, roll_deg, turned_deg, descriptor, found, opinion })
    }

    /// What is found by the descriptor that was just made, and what its network says by itself.
    fn found(&mut self, descriptor: &[f32]) -> Result<(Search, Option<NetworkEstimate>), RecogniseError> {
        let search = || self.index.search(descriptor, &self.search);
        let found = self.timings.time(|t| &mut t.search_ms, search)?;
        Ok((found, self.describer.opinion().cloned()))
    }

    /// The vote on the hand of the answer. A learned descriptor is one that a small turn changes
    /// otherwise than it changes the hand: it looks again from beside, and all looks vote.
    fn vote(&mut self, best: &Candidate, options: &VoteOptions) -> Result<Vote, RecogniseError> {
        let hand = self.hand_of(best.side);
        let beside = if self.index.catalogue().descriptor.is_learned() { LOOKS_DEG.as_slice() } else { &[] };
        let mut others = Vec::with_capacity(beside.len());
        for &turn_deg in beside {
            // A network turns the picture itself.
            let describe = || self.describer.describe_turned(hand, best.roll_deg + turn_deg, hand);
            let descriptor = self.timings.time(|t| &mut t.descriptor_ms, describe);
            let (found, opinion) = self.found(&descriptor)?;
            others.push((found.neighbours, opinion, turn_deg));
        }
        let own = Look { neighbours: &best.found.neighbours, opinion: best.opinion.as_ref(), turn_deg: 0.0 };
        let others = others.iter().map(|(neighbours, opinion, turn_deg)| Look {
            neighbours,
            opinion: opinion.as_ref(),
            turn_deg: *turn_deg,
        });
        let looks: Vec<Look> = std::iter::once(own).chain(others).collect();
        Ok(self.timings.time(|t| &mut t.vote_ms, || self.index.vote_of_looks(&looks, options)))
    }
}

fn mean_distance(neighbours: &[Neighbour]) -> f64 {
    let sum: f64 = neighbours.iter().map(|neighbour| f64::from(neighbour.distance)).sum();
    sum / neighbours.len().max(1) as f64
}
