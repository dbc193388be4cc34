//! What else is known of a hand than its picture: frames before it, the object that it holds.

use grasp_index::{Neighbour, euler_deg};

use super::{Doubt, Recogniser, Recognition};
use crate::prior;
use crate::recognition::Context;
use crate::sequence::{Belief, Filter, Turn};

impl Recogniser<'_> {
    /// What a picture alone says.
    pub fn belief(&self, found: &Recognition) -> Belief {
        let vote = &found.best.vote;
        let mut classes = vec![0.0; self.index.catalogue().classes.len()];
        for score in &vote.classes {
            if let Some(probability) = classes.get_mut(usize::from(score.class)) {
                *probability = score.probability;
            }
        }
        let turn = Turn { rotation: vote.orientation.rotation, spread_deg: vote.orientation.spread_deg };
        Belief { classes, side: found.best.side, turn }
    }

    /// Weighs the answer by how probable each class, by its number, is without the picture. Where
    /// that makes another class the first, the orientation is that of its neighbours, if it has
    /// any.
    pub fn weigh(&self, found: &mut Recognition, prior: &[f64]) {
        let before = found.best.vote.classes.first().map(|score| score.class);
        let weighed = prior::weigh(&self.belief(found).classes, prior);
        rank(found, &weighed);
        found.context = Context::Object;
        let first = found.best.vote.classes.first().map(|score| score.class);
        if first != before {
            let is_first = |neighbour: &&Neighbour| {
                self.index
                    .entry(neighbour.id)
                    .is_ok_and(|entry| entry.class.is_some() && entry.class == first)
            };
            let of_first: Vec<Neighbour> = found.best.neighbours.iter().filter(is_first).copied().collect();
            if !of_first.is_empty() {
                let mut orientation = self.index.vote(&of_first, &self.options.vote).orientation;
                orientation.rotation = found.best.in_picture(&orientation.rotation);
                orientation.euler_deg = euler_deg(&orientation.rotation);
                found.best.vote.orientation = orientation;
            }
        }
        found.doubt = found.doubt.filter(|doubt| !doubt.is_unsure()).or(self.unsure(found));
    }

    /// Makes of the answer to a frame what the frames before it and this one say together. A frame
    /// that shows an unknown hand says nothing, and is answered by the frames before it, if these
    /// show the hand that it is taken for. Which hand that is, each frame says by itself.
    pub fn follow(&self, found: &mut Recognition, filter: &mut Filter) {
        let frame = self.belief(found);
        let fused = match found.doubt {
            // No class stands out: that is what its probabilities say already.
            doubt if doubt.is_none_or(Doubt::is_unsure) => Some(filter.update(&frame)),
            _ => filter.skip(found.best.side),
        };
        let Some(fused) = fused else { return };
        rank(found, &fused.classes);
        found.context = Context::Frames;
        let orientation = &mut found.best.vote.orientation;
        orientation.rotation = fused.turn.rotation;
        orientation.euler_deg = euler_deg(&fused.turn.rotation);
        orientation.spread_deg = fused.turn.spread_deg;
        // How near this one frame lies no longer decides.
        found.doubt = self.unsure(found);
    }

    /// Whether no class stands out, wherever the neighbours lie.
    fn unsure(&self, found: &Recognition) -> Option<Doubt> {
        self.options.accept.unsure(self.index, &found.best.vote, found.tempering, &self.options.vote)
    }
}

/// Gives the classes these probabilities, by their numbers, and puts the most probable first.
fn rank(found: &mut Recognition, probabilities: &[f64]) {
    let classes = &mut found.best.vote.classes;
    for score in classes.iter_mut() {
        score.probability = probabilities.get(usize::from(score.class)).copied().unwrap_or(0.0);
    }
    // Stable, from the classes' numbers on: equals stay in that order.
    classes.sort_by_key(|score| score.class);
    classes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
}
