//! Endless lists of scenes, no two of the same hand in the same pose.

use std::sync::Arc;

use grasp_renders::random::unit;
use grasp_renders::{
    Grasp, HandModel, HandShape, Look, PoseGroup, Preset, RenderPlan, SceneSpec, Stage, Variation,
    alike_grasps, presented_grasps,
};
use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How often the stages before the grasp are drawn: most pictures that are asked about show the
/// grasp itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageShares {
    /// The share of reaches.
    pub reach: f64,
    /// The share of hands about to close.
    pub close: f64,
}

impl Default for StageShares {
    fn default() -> Self {
        Self { reach: 0.2, close: 0.25 }
    }
}

impl StageShares {
    /// The stage of a number from 0 to 1.
    fn stage(&self, number: f64) -> Stage {
        match number {
            x if x < self.reach => Stage::Reach,
            x if x < self.reach + self.close => Stage::Close,
            _ => Stage::Grasp,
        }
    }
}

/// How far things that are held in another way are tilted in the hand, in degrees (standard
/// deviation).
const TILT_OF_WAYS: f64 = 25.0;
/// How differently far hands are closed on their way to a thing (standard deviation of the share):
/// some people's open much wider than they will have to.
const CLOSURE: f64 = 0.25;
/// Pixels a side of a render: somewhat more than a network sees, as augmentation turns and cuts it.
const SIDE: usize = 80;

/// Scenes by number.
#[derive(Clone, Debug)]
pub struct Scenes {
    grasps: Vec<Arc<Grasp>>,
    look: Look,
    variation: Variation,
    hands: Hands,
    /// How many of them are drawn; `None` of no end.
    count: Option<u64>,
    /// Whose hand takes the place of all that are drawn, if any.
    hand_model: Option<Arc<HandModel>>,
    stages: StageShares,
    /// The share of scenes in which a thing is held up at the finger tips, and of those in which
    /// the hand is posed as another grasp's, where a grasp has such ways.
    presented: f64,
    alike: f64,
    seed: u64,
}

/// A scene that was drawn.
#[derive(Debug)]
pub struct DrawnScene {
    /// What is to be rendered.
    pub spec: SceneSpec,
    /// The grasp's place in the list of classes.
    pub class: usize,
    /// Whether a thing is held up at the finger tips.
    pub is_presented: bool,
}

/// Whose hands are drawn. Hands that the presets of an index have are among neither.
#[derive(Clone, Copy, Debug)]
enum Hands {
    /// Half of all possible hands.
    Training,
    /// The other half.
    Others,
}

impl Scenes {
    /// What a network is trained on: hands in all stages, posed as `poses` allows.
    pub fn training(seed: u64, poses: PoseGroup) -> Self {
        let plan = RenderPlan::preset(Preset::Standard);
        Self {
            grasps: plan.grasps.iter().cloned().map(Arc::new).collect(),
            look: Look { side: SIDE, ..plan.look },
            variation: Variation { recorded_from: poses, closure: CLOSURE, ..plan.variation },
            hands: Hands::Training,
            count: None,
            hand_model: None,
            stages: StageShares::default(),
            presented: 0.0,
            alike: 0.0,
            seed,
        }
    }

    /// Hands that no training draws, at the grasp, posed as `poses` allows.
    pub fn other_hands(seed: u64, poses: PoseGroup) -> Self {
        Self {
            hands: Hands::Others,
            stages: StageShares { reach: 0.0, close: 0.0 },
            ..Self::training(seed, poses)
        }
    }

    /// The same hands, all of them in poses that are held out.
    pub fn held_out_poses(seed: u64) -> Self {
        let scenes = Self::other_hands(seed, PoseGroup::HeldOut);
        Self { variation: Variation { examples: 0.0, recorded: 1.0, ..scenes.variation }, ..scenes }
    }

    /// The same scenes of `count` hands; without it, of ever new ones.
    pub fn with_hands(self, count: Option<u64>) -> Self {
        Self { count, ..self }
    }

    /// The same scenes with one hand in the place of all that are drawn, if there is one.
    pub fn with_hand_model(self, hand_model: Option<Arc<HandModel>>) -> Self {
        Self { hand_model, ..self }
    }

    /// The same scenes in other stages.
    pub fn with_stages(self, stages: StageShares) -> Self {
        Self { stages, ..self }
    }

    /// The same scenes but for a share, in which things are held up as to a camera.
    pub fn with_presented(self, share: f64) -> Self {
        Self { presented: share, ..self }
    }

    /// The same scenes but for a share, in which hands are posed as in another grasp.
    pub fn with_alike(self, share: f64) -> Self {
        Self { alike: share, ..self }
    }

    /// How many classes there are.
    pub fn classes(&self) -> usize {
        self.grasps.len()
    }

    /// Scene `number`.
    pub fn scene(&self, number: u64) -> DrawnScene {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number);
        let drawn = rng.next_u64();
        let drawn = self.count.map_or(drawn, |count| drawn % count.max(1));
        let hand_shape = match &self.hand_model {
            Some(model) => model.shape().clone(),
            None => HandShape::sample(match self.hands {
                Hands::Training => drawn | 1 << 63,
                Hands::Others => drawn & !(1 << 63),
            }),
        };
        // Classes take turns, so that each has its share of every batch.
        let class = (number % self.grasps.len() as u64) as usize;
        let stage = self.stages.stage(unit(&mut rng));
        let size = unit(&mut rng);
        let (chance, which) = (unit(&mut rng), unit(&mut rng));
        let way = |ways: &'static [Arc<Grasp>]| way(ways, &self.grasps[class].name, which);
        let presented = way(presented_grasps()).filter(|_| chance < self.presented);
        let alike = way(alike_grasps()).filter(|_| chance >= 1.0 - self.alike);
        let other = presented.or(alike);
        let variation = if other.is_some() { &self.variation_of_ways() } else { &self.variation };
        let grasp = other.unwrap_or(&self.grasps[class]);
        let spec = SceneSpec {
            hand_shape: Arc::new(hand_shape),
            hand_model: self.hand_model.clone(),
            grasp: Arc::clone(grasp),
            stage,
            object: grasp.object.object(size),
            example: None,
            held: None,
            look: self.look.clone(),
            seed: self.seed ^ number,
        };
        DrawnScene { spec: variation.vary(spec), class, is_presented: presented.is_some() }
    }

    fn variation_of_ways(&self) -> Variation {
        Variation { examples: 0.0, recorded: 0.0, tilt_deg: TILT_OF_WAYS, ..self.variation.clone() }
    }
}

/// The one of a grasp's ways that a number from 0 to 1 says; `None` where it has none.
fn way(ways: &'static [Arc<Grasp>], name: &str, which: f64) -> Option<&'static Arc<Grasp>> {
    let ways: Vec<_> = ways.iter().filter(|way| way.name == name).collect();
    ways.get((which * ways.len() as f64) as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEPT: PoseGroup = PoseGroup::Kept { percent: 100 };

    #[test]
    fn so_many_hands_are_drawn_as_are_asked_for() {
        let shapes = |count| {
            let scenes = Scenes::training(7, PoseGroup::All).with_hands(count);
            let mut shapes = Vec::new();
            for number in 0..40 {
                let shape = scenes.scene(number).spec.hand_shape;
                if !shapes.contains(&shape) {
                    shapes.push(shape);
                }
            }
            shapes.len()
        };
        assert_eq!([Some(1), Some(3), None].map(shapes), [1, 3, 40]);
    }

    #[test]
    fn classes_take_turns_and_stages_have_their_shares() {
        let scenes = Scenes::training(7, PoseGroup::All);
        let drawn: Vec<_> = (0..600).map(|number| scenes.scene(number)).collect();
        assert!(drawn.iter().enumerate().all(|(number, drawn)| drawn.class == number % scenes.classes()));
        for (stage, share) in [(Stage::Reach, 0.2), (Stage::Close, 0.25), (Stage::Grasp, 0.55)] {
            let found = drawn.iter().filter(|drawn| drawn.spec.stage == stage).count() as f64 / 600.0;
            assert!((found - share).abs() < 0.07, "{stage}: {found}");
        }
        let again = Scenes::training(7, PoseGroup::All).scene(5).spec.params_hash();
        assert_eq!(drawn[5].spec.params_hash(), again);
        assert_ne!(Scenes::training(8, PoseGroup::All).scene(5).spec.params_hash(), again);
    }

    #[test]
    fn scenes_to_measure_by_show_other_hands_at_the_grasp() {
        let training = Scenes::training(7, KEPT);
        let (hands, poses) = (Scenes::other_hands(7, KEPT), Scenes::held_out_poses(7));
        for number in 0..60 {
            let trained = training.scene(number).spec.hand_shape;
            let [hand, pose] = [&hands, &poses].map(|scenes| scenes.scene(number).spec);
            assert!(hand.hand_shape != trained && pose.hand_shape != trained);
            assert_eq!([hand.stage, pose.stage], [Stage::Grasp; 2]);
            assert!(pose.held.is_some() && pose.example.is_none());
        }
    }

    #[test]
    fn hands_are_posed_as_another_grasps_in_a_share_of_the_scenes() {
        let plain = Scenes::training(7, PoseGroup::All);
        let some = Scenes::training(7, PoseGroup::All).with_alike(0.25);
        let about = |scenes: &Scenes, number| scenes.scene(number).spec.grasp.about.clone();
        let other = (0..600).filter(|number| about(&some, *number) != about(&plain, *number)).count();
        // Three of the six grasps have such ways.
        assert!((55..95).contains(&other), "{other} of 300");
        assert!((0..600).all(|number| !some.scene(number).is_presented));
    }

    #[test]
    fn things_are_held_up_in_a_share_of_the_scenes_and_the_others_stay_as_they_are() {
        let plain = Scenes::training(7, PoseGroup::All);
        let some = Scenes::training(7, PoseGroup::All).with_presented(0.4);
        let has_way =
            |class: usize| presented_grasps().iter().any(|way| way.name == plain.grasps[class].name);
        let (mut presented, mut possible) = (0, 0);
        for number in 0..600 {
            let [was, is] = [&plain, &some].map(|scenes| scenes.scene(number));
            possible += usize::from(has_way(is.class));
            presented += usize::from(is.is_presented);
            assert_eq!(is.is_presented, is.spec.params_hash() != was.spec.params_hash());
            assert_eq!(is.spec.grasp.name, was.spec.grasp.name);
        }
        assert_eq!(possible, 300);
        assert!((100..140).contains(&presented), "{presented} of {possible}");
    }
}
