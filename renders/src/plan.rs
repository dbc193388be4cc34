//! Which renders to make.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use crate::grasp::{GraspSet, Stage};
use crate::hand::HandShape;
use crate::scene::{Look, SceneSpec};
use crate::view::{View, ViewGrid};

/// A named plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// As in the paper: one hand shape, six grasps, 900 views each over the upper half-sphere.
    Paper,
    /// Several hand shapes, all stages, two object sizes, both half-spheres, rolls all round.
    Wide,
}

impl Preset {
    /// Both presets.
    pub const ALL: [Preset; 2] = [Preset::Paper, Preset::Wide];

    /// `paper` or `wide`.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Paper => "paper",
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
#[error("`{0}` is no preset; the presets are paper and wide")]
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

/// Which renders to make: every hand shape in every grasp at every stage with every object size, from
/// every view.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderPlan {
    /// Whose hands.
    pub hand_shapes: Vec<HandShape>,
    /// The grasps.
    pub grasps: GraspSet,
    /// The stages.
    pub stages: Vec<Stage>,
    /// Object sizes as shares (0 to 1) of the grasp's own range.
    pub object_sizes: Vec<f64>,
    /// The camera directions.
    pub grid: ViewGrid,
    /// How a picture is taken.
    pub look: Look,
    /// Seed of all variations.
    pub seed: u64,
}

impl RenderPlan {
    /// The plan of a preset with seed 0.
    pub fn preset(preset: Preset) -> RenderPlan {
        let paper = RenderPlan {
            hand_shapes: vec![HandShape::mean()],
            grasps: GraspSet::builtin(),
            stages: vec![Stage::Grasp],
            object_sizes: vec![0.5],
            grid: ViewGrid::default(),
            look: Look::default(),
            seed: 0,
        };
        match preset {
            Preset::Paper => paper,
            Preset::Wide => RenderPlan {
                hand_shapes: hands(3),
                stages: vec![Stage::Close, Stage::Grasp],
                object_sizes: vec![0.2, 0.8],
                grid: ViewGrid {
                    step_deg: 15.0,
                    elevation_deg: [-75.0, 75.0],
                    rolls_deg: (0..12).map(|i| f64::from(i) * 30.0).collect(),
                },
                look: Look { distance_variation: 0.2, light_variation: 0.3, ..Look::default() },
                ..paper
            },
        }
    }

    /// The same plan with `n` hand shapes: the presets first, then sampled hands.
    pub fn with_hands(self, n: usize) -> RenderPlan {
        RenderPlan { hand_shapes: hands(n), ..self }
    }

    /// All scenes, in a fixed order.
    pub fn scenes(&self) -> Vec<SceneSpec> {
        let mut scenes = Vec::new();
        let grasps: Vec<_> = self.grasps.iter().cloned().map(Arc::new).collect();
        for shape in &self.hand_shapes {
            let shape = Arc::new(shape.clone());
            for grasp in &grasps {
                for &stage in &self.stages {
                    for &size in &self.object_sizes {
                        scenes.push(SceneSpec {
                            hand_shape: Arc::clone(&shape),
                            grasp: Arc::clone(grasp),
                            stage,
                            object: grasp.object.object(size),
                            look: self.look.clone(),
                            seed: self.seed,
                        });
                    }
                }
            }
        }
        scenes
    }

    /// All views of each scene, in a fixed order.
    pub fn views(&self) -> Vec<View> {
        self.grid.views()
    }

    /// How many renders the plan makes.
    pub fn renders(&self) -> usize {
        let scenes = self.hand_shapes.len() * self.grasps.len() * self.stages.len() * self.object_sizes.len();
        scenes * self.views().len()
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
        assert_eq!(plan.scenes().len() * plan.views().len(), plan.renders());
        assert!(plan.renders() < 300_000, "{}", plan.renders());
        assert!(plan.views().iter().any(|v| v.elevation_deg < -45.0));
        assert!(plan.views().iter().any(|v| v.roll_deg > 170.0));
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
