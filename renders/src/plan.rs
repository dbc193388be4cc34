//! Which renders to make.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::grasp::{GraspSet, Stage};
use crate::hand::HandShape;
use crate::hand_model::HandModel;
use crate::scene::{Look, SceneSpec};
use crate::variation::Variation;
use crate::view::{View, ViewGrid, Views};

/// Object sizes, at the grasp and before it, of the presets of people's hands: 72 scenes a hand
/// shape.
const SIZES: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
const SIZES_BEFORE: [f64; 3] = [0.2, 0.5, 0.8];
/// Hand shapes and views a scene of `standard`: 2,880 scenes, 103,680 renders, as many as an index
/// of 150 MB holds.
const STANDARD: (usize, usize) = (40, 36);
/// The same of `wide`: 11,160 scenes, 669,600 renders, as many as an index of 1 GB holds.
const WIDE: (usize, usize) = (155, 60);

/// A named plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// As in the paper: one hand shape, six grasps, 900 views each over the upper half-sphere.
    Paper,
    /// Forty hand shapes, all stages, objects of any size, poses and arms that vary as people's do,
    /// and views from everywhere with any roll: what recognises pictures, and is built in a minute.
    Standard,
    /// The same with more hand shapes and more views of each.
    Wide,
}

impl Preset {
    /// All presets.
    pub const ALL: [Preset; 3] = [Preset::Paper, Preset::Standard, Preset::Wide];

    /// `paper`, `standard` or `wide`.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Paper => "paper",
            Preset::Standard => "standard",
            Preset::Wide => "wide",
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that names no preset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no preset `{0}`: the presets are paper, standard and wide")]
pub struct UnknownPreset(pub String);

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(word: &str) -> Result<Preset, UnknownPreset> {
        Preset::ALL
            .into_iter()
            .find(|preset| preset.name() == word)
            .ok_or_else(|| UnknownPreset(word.to_owned()))
    }
}

/// Which renders to make: every hand shape in every grasp at every stage with every object size,
/// from every view.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderPlan {
    /// Whose hands.
    pub hand_shapes: Vec<HandShape>,
    /// Hands that were read from files, rendered after those.
    pub hand_models: Vec<Arc<HandModel>>,
    /// The grasps.
    pub grasps: GraspSet,
    /// The stages.
    pub stages: Vec<Stage>,
    /// Object sizes at the grasp as shares (0 to 1) of the grasp's own range.
    pub object_sizes: Vec<f64>,
    /// The same at the stages before it, where the hand does not show so well what it is going to
    /// hold.
    pub object_sizes_before: Vec<f64>,
    /// The camera directions.
    pub views: Views,
    /// How a picture is taken.
    pub look: Look,
    /// How scenes differ from what the data say.
    pub variation: Variation,
    /// Seed of all variations.
    pub seed: u64,
}

impl RenderPlan {
    /// The plan of a preset with seed 0.
    pub fn preset(preset: Preset) -> RenderPlan {
        match preset {
            Preset::Paper => RenderPlan {
                hand_shapes: vec![HandShape::mean()],
                hand_models: Vec::new(),
                grasps: GraspSet::builtin(),
                stages: vec![Stage::Grasp],
                object_sizes: vec![0.5],
                object_sizes_before: vec![0.5],
                views: Views::Grid(ViewGrid::default()),
                look: Look::default(),
                variation: Variation::NONE,
                seed: 0,
            },
            Preset::Standard => RenderPlan::people(STANDARD),
            Preset::Wide => RenderPlan::people(WIDE),
        }
    }

    /// So many hand shapes, as people have them and hold things, and so many views of each scene.
    fn people((hand_shapes, views): (usize, usize)) -> RenderPlan {
        RenderPlan {
            hand_shapes: hands(hand_shapes),
            stages: Stage::ALL.to_vec(),
            object_sizes: SIZES.to_vec(),
            object_sizes_before: SIZES_BEFORE.to_vec(),
            views: Views::Random(views),
            look: Look { distance_variation: 0.25, light_variation: 0.6, ..Look::default() },
            variation: Variation::PEOPLE,
            ..RenderPlan::preset(Preset::Paper)
        }
    }

    /// The same plan with `n` hand shapes: the presets first, then sampled hands. Hand models stay.
    pub fn with_hands(self, n: usize) -> RenderPlan {
        RenderPlan { hand_shapes: hands(n), ..self }
    }

    /// All scenes, in a fixed order.
    pub fn scenes(&self) -> Vec<SceneSpec> {
        let mut scenes = Vec::new();
        let grasps: Vec<_> = self.grasps.iter().cloned().map(Arc::new).collect();
        let shapes = self.hand_shapes.iter().map(|shape| (Arc::new(shape.clone()), None));
        let models = self.hand_models.iter().map(|m| (Arc::new(m.shape().clone()), Some(Arc::clone(m))));
        for (shape, model) in shapes.chain(models) {
            for grasp in &grasps {
                for &stage in &self.stages {
                    for &size in self.sizes(stage) {
                        let spec = SceneSpec {
                            hand_shape: Arc::clone(&shape),
                            hand_model: model.clone(),
                            grasp: Arc::clone(grasp),
                            stage,
                            object: grasp.object.object(size),
                            example: None,
                            held: None,
                            look: self.look.clone(),
                            seed: self.seed,
                        };
                        scenes.push(self.variation.vary(spec));
                    }
                }
            }
        }
        scenes
    }

    /// All views of a scene, in a fixed order; they follow from the scene's own parameters.
    pub fn views(&self, scene: &SceneSpec) -> Vec<View> {
        match &self.views {
            Views::Grid(grid) => grid.views(),
            Views::Random(count) => {
                // Another stream than the variations of light and distance.
                let mut rng = ChaCha8Rng::seed_from_u64(scene.params_hash());
                rng.set_stream(1);
                (0..*count).map(|_| View::random(&mut rng)).collect()
            }
        }
    }

    /// How many renders the plan makes.
    pub fn renders(&self) -> usize {
        let hands = self.hand_shapes.len() + self.hand_models.len();
        let sizes: usize = self.stages.iter().map(|&stage| self.sizes(stage).len()).sum();
        hands * self.grasps.len() * sizes * self.views.count()
    }

    fn sizes(&self, stage: Stage) -> &[f64] {
        if stage == Stage::Grasp { &self.object_sizes } else { &self.object_sizes_before }
    }
}

/// The first `n` hands: the mean, the presets, then sampled ones.
fn hands(n: usize) -> Vec<HandShape> {
    HandShape::presets().into_iter().chain((0..).map(HandShape::sample)).take(n).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_preset_is_the_papers() {
        let plan = RenderPlan::preset(Preset::Paper);
        assert_eq!(plan.scenes().len(), 6);
        assert_eq!(plan.renders(), 5400);
    }

    #[test]
    fn the_wide_preset_covers_rolls_and_both_half_spheres() {
        let plan = RenderPlan::preset(Preset::Wide);
        let scenes = plan.with_hands(2).scenes();
        let plan = RenderPlan::preset(Preset::Wide);
        assert!(plan.renders() < 700_000, "{}", plan.renders());
        let views: Vec<View> = scenes.iter().flat_map(|scene| plan.views(scene)).collect();
        assert_eq!(views.len(), scenes.len() * WIDE.1);
        let share =
            |is: fn(&View) -> bool| views.iter().filter(|v| is(v)).count() as f64 / views.len() as f64;
        // A band of a sphere is as large as it is high.
        assert!((share(|v| v.elevation_deg < -30.0) - 0.25).abs() < 0.03);
        assert!((share(|v| v.roll_deg > 270.0) - 0.25).abs() < 0.03);
        assert_ne!(plan.views(&scenes[0]), plan.views(&scenes[1]));
        assert_eq!(plan.views(&scenes[0]), plan.views(&scenes[0]));
    }

    #[test]
    fn varied_scenes_differ_and_follow_from_the_seed() {
        let plan = |seed| RenderPlan { seed, ..RenderPlan::preset(Preset::Wide).with_hands(20) };
        let (scenes, again, other) = (plan(0).scenes(), plan(0).scenes(), plan(1).scenes());
        assert!(scenes.iter().zip(&again).all(|(a, b)| a.params_hash() == b.params_hash()));
        assert!(scenes.iter().zip(&other).all(|(a, b)| a.params_hash() != b.params_hash()));
        let posed = scenes.iter().filter(|scene| scene.example.is_some()).count() as f64;
        assert!((posed / scenes.len() as f64 - 0.5).abs() < 0.06, "{posed} of {}", scenes.len());
        let held = scenes.iter().filter(|scene| scene.held.is_some()).count() as f64;
        assert!((held / scenes.len() as f64 - 0.25).abs() < 0.06, "{held} of {}", scenes.len());
        let mut arms: Vec<f64> = scenes.iter().map(|scene| scene.look.forearm).collect();
        arms.sort_by(f64::total_cmp);
        assert!(arms[0] < 0.01 && arms[arms.len() - 1] > 0.15, "the whole range of arms");
        for (a, b) in scenes.iter().zip(&scenes[1..]) {
            assert_ne!(a.object, b.object);
        }
    }

    #[test]
    fn scenes_have_different_hashes() {
        let plan = RenderPlan::preset(Preset::Wide).with_hands(9);
        let mut hashes: Vec<u64> = plan.scenes().iter().map(SceneSpec::params_hash).collect();
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), plan.scenes().len());
        assert_eq!(plan.hand_shapes[8].name, "hand-1");
    }

    #[test]
    fn names_are_read_back() {
        for preset in Preset::ALL {
            assert_eq!(preset.to_string().parse(), Ok(preset));
        }
        assert!("narrow".parse::<Preset>().is_err());
    }
}
