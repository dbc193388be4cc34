//! What the scene network says, together with what the neighbours say.

use grasp_index::{Index, Vote};

use super::Scene;
use crate::side::Side;

/// The powers of the neighbours' and of the network's probabilities: both see the same hand, and
/// are sure of the same mistakes. Chosen on camera pictures of two hands (docs/accuracy.md).
const NEIGHBOURS: f64 = 0.72;
const NETWORK: f64 = 1.2;
/// The least probability that is taken seriously: neither is so sure.
const LEAST: f64 = 1e-3;

impl Scene {
    /// The probability that the hand is the other one than `side`.
    pub(crate) fn is_other_hand(&self, side: Side) -> f64 {
        let odds = if side == Side::Right { self.right_odds } else { -self.right_odds };
        1.0 / (1.0 + libm::exp(odds))
    }

    /// Weighs the neighbours' classes by what the network makes of hand and object. Classes that it
    /// does not know count as its mean. Returns how likely the hand is in none of the grasps, of
    /// which the neighbours know nothing: to them it is as likely as any class.
    pub(crate) fn join(&self, index: &Index, side: Side, vote: &mut Vote) -> f64 {
        let probabilities = self.probabilities(side);
        let grasps = probabilities.len() - 1;
        let known: f64 = probabilities[..grasps].iter().sum();
        let of_name = |name: &str| {
            let at = self.grasps.iter().position(|grasp| grasp == name);
            at.map_or(1.0 / grasps as f64, |at| probabilities[at] / known.max(LEAST))
        };
        for score in &mut vote.classes {
            let name = index.catalogue().classes.get(usize::from(score.class));
            let by_scene = name.map_or(0.0, |class| of_name(&class.name));
            let by_neighbours = libm::pow(score.probability.max(LEAST), NEIGHBOURS);
            score.probability = by_neighbours * libm::pow(by_scene.max(LEAST), NETWORK);
        }
        let total: f64 = vote.classes.iter().map(|score| score.probability).sum();
        let even = libm::pow(1.0 / vote.classes.len().max(1) as f64, NEIGHBOURS);
        let none = even * libm::pow(probabilities[grasps].max(LEAST), NETWORK);
        let some = total * libm::pow(known, NETWORK);
        vote.classes.iter_mut().for_each(|score| score.probability /= total);
        vote.classes.sort_by_key(|score| score.class);
        vote.classes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        none / (none + some)
    }
}
