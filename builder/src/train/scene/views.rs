//! Views of scenes in colour, before they are painted.

use std::sync::Arc;

use grasp_renders::random::{between, unit};
use grasp_renders::{Layers, PosedHand, Randomised, SceneSpec, Stage, View, world_from_hand};
use nalgebra::Vector3;
use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::empty;
use crate::train::joints::Joints;
use crate::train::{DrawnScene, LeftOut, Scenes};

/// How often a hand is in none of the grasps.
const EMPTY: f64 = 0.09;
/// How often what is not yet held is there at all.
const IN_SIGHT: f64 = 0.8;
/// How often a thing is held up at the finger tips, and how often the hand is posed as in another
/// grasp, in grasps that have such ways.
const PRESENTED: f64 = 0.4;
const ALIKE: f64 = 0.22;
/// Distances of the camera, in hand lengths.
const DISTANCE: [f64; 2] = [2.0, 8.0];
/// What the thing in the hand looks like is drawn by another seed than the hand.
const SEED_OF_THINGS: u64 = 3;

/// Endless scenes, and what is seen of them.
#[derive(Debug)]
pub(super) struct Views {
    scenes: Scenes,
    /// The same without things that are held up.
    in_hand: Scenes,
    /// How often a hand is to be cut out of its picture.
    cut_out: f64,
    randomised: Randomised,
    seed: u64,
}

/// One view of a scene.
#[derive(Debug)]
pub struct SceneView {
    pub(super) layers: Layers,
    /// The grasp's place in the list of classes; `None` of a hand in none of them.
    pub(super) class: Option<usize>,
    pub(super) stage: Stage,
    pub(super) joints: Arc<Joints>,
    /// Whether the hand is to be cut out of its picture.
    pub(super) is_cut_out: bool,
}

impl Views {
    /// Views of these scenes: the hand is cut out in a share `cut_out` of them, and what is in
    /// `left_out` does not vary.
    pub(super) fn new(scenes: Scenes, cut_out: f64, left_out: &[LeftOut], seed: u64) -> Self {
        let of_ways = |share| if left_out.contains(&LeftOut::Ways) { 0.0 } else { share };
        let in_hand = scenes.with_alike(of_ways(ALIKE));
        let scenes = in_hand.clone().with_presented(of_ways(PRESENTED));
        Self { scenes, in_hand, cut_out, randomised: LeftOut::randomised(left_out), seed }
    }

    /// How many grasps there are.
    pub(super) fn classes(&self) -> usize {
        self.scenes.classes()
    }

    /// What is random in pictures of them.
    pub(super) fn randomised(&self) -> Randomised {
        self.randomised
    }

    /// The place in the heads of a hand that is mirrored: behind the grasps.
    pub(super) fn mirrored(&self) -> u32 {
        self.classes() as u32
    }

    /// The place of a hand in none of the grasps, and of no hand.
    pub(super) fn none(&self) -> u32 {
        self.mirrored() + 1
    }

    /// Random views of a numbered scene.
    pub(super) fn render(&self, number: u64, views: usize) -> anyhow::Result<Vec<SceneView>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ SEED_OF_THINGS);
        rng.set_stream(number);
        let is_cut_out = unit(&mut rng) < self.cut_out;
        let DrawnScene { mut spec, class, is_presented } = self.drawn(number, is_cut_out);
        let is_empty = unit(&mut rng) < EMPTY;
        let mut is_held = spec.stage == Stage::Grasp || unit(&mut rng) < IN_SIGHT;
        if is_empty {
            spec = empty::posed(spec, &mut rng);
            is_held = false;
        }
        let stage = spec.stage;
        let hand = PosedHand::build(&spec)?;
        let joints = Arc::new(Joints::new(hand.joints(), hand.hand_length()));
        let class = (!is_empty).then_some(class);
        let view = |rng: &mut ChaCha8Rng| {
            let distance = between(rng, DISTANCE);
            let scene = hand.dressed(is_held, self.randomised, rng.next_u64());
            SceneView {
                layers: scene.layers(&seen_from(&spec, is_presented, rng), distance),
                class,
                stage,
                joints: Arc::clone(&joints),
                is_cut_out,
            }
        };
        Ok((0..views).map(|_| view(&mut rng)).collect())
    }

    /// Without the thing, hands that hold something up are all one grasp: none of those is cut out.
    fn drawn(&self, number: u64, is_cut_out: bool) -> DrawnScene {
        if is_cut_out { self.in_hand.scene(number) } else { self.scenes.scene(number) }
    }
}

/// A random view; of a hand that holds something up, the palm's side more often.
fn seen_from(spec: &SceneSpec, is_presented: bool, rng: &mut ChaCha8Rng) -> View {
    let view = View::random(rng);
    let back = view.camera_from_world() * world_from_hand(&spec.grasp.up) * Vector3::z();
    let is_back_seen = back.z < 0.0;
    if is_presented && is_back_seen { View::random(rng) } else { view }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_renders::PoseGroup;

    #[test]
    fn hands_that_are_cut_out_hold_nothing_up_and_the_others_often_do() {
        let views = Views::new(Scenes::training(7, PoseGroup::All), 0.5, &[], 7);
        let presented =
            |is_cut_out| (0..300).filter(|number| views.drawn(*number, is_cut_out).is_presented).count();
        assert_eq!(presented(true), 0);
        assert!((40..90).contains(&presented(false)), "{}", presented(false));
    }

    #[test]
    fn a_share_of_the_scenes_is_cut_out_with_all_its_views() {
        let views = Views::new(Scenes::training(7, PoseGroup::All), 0.5, &[], 7);
        let seen: Vec<_> = (0..12).map(|number| views.render(number, 2).expect("a scene")).collect();
        let cut_out = seen.iter().filter(|views| views[0].is_cut_out).count();
        assert!((2..11).contains(&cut_out), "{cut_out}");
        assert!(seen.iter().all(|views| views[0].is_cut_out == views[1].is_cut_out));
        let none = Views::new(Scenes::training(7, PoseGroup::All), 0.0, &[], 7);
        assert!((0..6).all(|number| !none.render(number, 1).expect("a scene")[0].is_cut_out));
    }
}
