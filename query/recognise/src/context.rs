//! Applies what is known of a hand besides its picture: earlier frames, or the object that it
//! holds.

use grasp_index::{ClassScore, Neighbour, euler_deg};

use super::{Doubt, Recogniser, Recognition};
use crate::doubtful;
use crate::prior;
use crate::recognition::Context;
use crate::scene::join_orientation;
use crate::sequence::{Belief, Filter, Turn};
use crate::thorough;

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
    /// any, and of the networks that look at the hand, and so is what is said of its neighbours'
    /// disagreement.
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
                join_orientation(&found.seen, &mut orientation);
                thorough::join_orientation(&found.seen_in_variants, &mut orientation);
                doubtful::point_out_disagreement(&mut found.warnings, orientation.spread_deg);
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
    ClassScore::rank(classes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_index::{
        ClassInfo, DescriptorParams, HandImage, Index, IndexParams, IndexWriter, NewEntry, VoteOptions,
    };
    use nalgebra::UnitQuaternion;

    use crate::picture::Picture;
    use crate::segment::SegmentParams;
    use crate::{HandChoice, MaskSource, Prepared, RecogniseOptions, Timings, Warning};

    const SIDE: usize = 32;

    fn about_z(degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(0.0, 0.0, degrees.to_radians())
    }

    /// A block with one finger, or with two.
    fn grey(class: u16) -> Vec<u8> {
        let is_hand = |x: usize, y: usize| match class {
            0 => (8..24).contains(&x) && y > 16 || (8..12).contains(&x) && y > 2,
            _ => (4..28).contains(&x) && y > 20 || (4..9).contains(&x) && y > 8 || x > 22 && x < 28 && y > 8,
        };
        (0..SIDE * SIDE).map(|at| if is_hand(at % SIDE, at / SIDE) { 200 } else { 0 }).collect()
    }

    /// Ten views of either class, those of the second turned by so many degrees by turns.
    fn index(turns: [f64; 2]) -> Index {
        let class = |name: &str, cutkosky| ClassInfo { name: name.into(), cutkosky };
        let descriptor = DescriptorParams::default();
        let mut writer = IndexWriter::new(IndexParams {
            descriptor,
            classes: vec![class("pinch", 9), class("power-sphere", 10)],
            hand_shapes: vec!["mean".into()],
            stages: vec!["grasp".into()],
            ..IndexParams::default()
        })
        .unwrap();
        for n in 0..20u16 {
            let class = n % 2;
            let hand = HandImage::from_segmented(SIDE, SIDE, &grey(class), 0).unwrap();
            writer
                .push(NewEntry {
                    class,
                    orientation: about_z(if class == 0 { 80.0 } else { turns[usize::from(n / 2 % 2)] }),
                    descriptor: descriptor.describe(&hand).unwrap(),
                    ..NewEntry::default()
                })
                .unwrap();
        }
        Index::from_bytes(&writer.finish_bytes().unwrap()).unwrap()
    }

    /// All entries vote, and both classes have some of the vote: equal views make sigma 0.
    fn options() -> RecogniseOptions {
        let vote = VoteOptions { sigma: Some(1.0), ..VoteOptions::default() };
        RecogniseOptions { k: Some(20), hand: HandChoice::Right, vote, ..RecogniseOptions::default() }
    }

    fn found(recogniser: &Recogniser<'_>) -> Recognition {
        let pixels = grey(0).into_iter().map(|value| [value; 3]).collect();
        let picture = Picture::new(SIDE, SIDE, pixels).unwrap();
        let params = SegmentParams::default();
        let prepared = Prepared::new(picture, false, &MaskSource::Segmented, &params).unwrap();
        recogniser.recognise_prepared(prepared, Timings::default()).unwrap()
    }

    #[test]
    fn where_a_prior_makes_another_class_the_first_networks_still_say_how_the_hand_is_turned() {
        let index = index([0.0, 0.0]);
        let recogniser = Recogniser::new(&index, options());
        let weighed = |seen: &[f64]| {
            let mut found = found(&recogniser);
            assert_eq!(found.best.vote.classes[0].class, 0);
            found.seen = seen.iter().copied().map(about_z).collect();
            recogniser.weigh(&mut found, &[1e-9, 1.0]);
            assert_eq!(found.best.vote.classes[0].class, 1);
            found.best.vote.orientation
        };
        let alone = weighed(&[]);
        assert!(alone.rotation.angle_to(&about_z(0.0)).to_degrees() < 0.1);
        let joined = weighed(&[20.0]);
        let moved = joined.rotation.angle_to(&about_z(0.0)).to_degrees();
        assert!((5.0..15.0).contains(&moved), "{moved}");
        assert!((joined.euler_deg[2] - moved).abs() < 0.1, "{:?}", joined.euler_deg);
    }

    #[test]
    fn a_warning_of_disagreement_is_about_the_class_of_the_answer() {
        let disagree = |found: &Recognition| {
            found.warnings.iter().any(|warning| matches!(warning, Warning::NeighboursDisagree { .. }))
        };
        for (turns, is_said) in [([0.0, 0.0], false), ([0.0, 170.0], true)] {
            let index = index(turns);
            let recogniser = Recogniser::new(&index, options());
            let mut found = found(&recogniser);
            found.warnings.push(Warning::NeighboursDisagree { spread_deg: 77.0 });
            recogniser.weigh(&mut found, &[1e-9, 1.0]);
            let spread_deg = found.best.vote.orientation.spread_deg;
            assert_eq!(disagree(&found), is_said, "{spread_deg}");
            assert!(!found.warnings.contains(&Warning::NeighboursDisagree { spread_deg: 77.0 }));
        }
    }
}
