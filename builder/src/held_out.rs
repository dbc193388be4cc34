//! Descriptors of hands that an index does not hold, to measure its search by: what is asked in
//! practice is never a hand that was rendered for the index.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use grasp_index::{DescriptorModel, NOISE, mean_distance, moved_along};
use grasp_renders::{
    HandShape, Look, RENDERER_VERSION, RenderPlan, SceneSpec, Stage, Variation, View, Views,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::array::Rows;
use crate::descriptor::hand_in;
use crate::interrupt;

/// Sampled hands from this seed on are nobody's: plans count theirs up from 0.
const FIRST_SEED: u64 = 2_000_000;
/// Hand shapes that a build holds out.
pub const HANDS: usize = 6;
/// Of these, how many are seen in each grasp: posing and meshing a hand takes as long as a hundred
/// views of it.
const HANDS_A_GRASP: usize = 4;
/// Views of them: half a second's work for two cores.
pub const VIEWS: usize = 1_200;
/// How far light and distance vary at least.
const LIGHT: f64 = 0.3;
const DISTANCE: f64 = 0.2;
/// Rows that sigma is measured over, at most.
const PAIRED: usize = 1_000;

/// Where held-out descriptors come from.
#[derive(Clone, Debug)]
pub enum HeldOut {
    /// There are none: entries of the index stand in.
    Nothing,
    /// Rendered.
    Rendered(Box<Hands>),
    /// Read from an array.
    File(PathBuf),
}

impl HeldOut {
    /// What the index says of them: as long as it is the same, so are they.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn provenance(&self) -> anyhow::Result<Option<String>> {
        Ok(match self {
            Self::Nothing => None,
            Self::Rendered(hands) => Some(hands.to_string()),
            Self::File(path) => {
                let rows = Rows::open(path)?;
                let (name, len) = (path.file_name().unwrap_or_default().to_string_lossy(), rows.len());
                let xxh3 = rows.digest().with_context(|| cannot_use(path))?;
                Some(format!("{name}, {len} rows, xxh3 {xxh3:016x}"))
            }
        })
    }

    /// The descriptors, in rows, and what they show.
    ///
    /// # Errors
    /// When the file cannot be read or has rows of another length, or the work was interrupted.
    pub fn describe(&self, model: &DescriptorModel) -> anyhow::Result<HeldOutQueries> {
        match self {
            Self::Nothing => Ok(HeldOutQueries::default()),
            Self::Rendered(hands) => hands.describe(model),
            Self::File(path) => {
                let rows = Rows::open(path)?;
                let (found, dim) = (rows.columns(), model.params().dim());
                if found != dim as u64 {
                    anyhow::bail!(
                        "{} has rows of {found} values, the index's have {dim}: they must be alike",
                        path.display()
                    );
                }
                let descriptors = rows.all().with_context(|| cannot_use(path))?;
                Ok(HeldOutQueries { descriptors, grasps: Vec::new() })
            }
        }
    }
}

/// Held-out descriptors.
#[derive(Clone, Debug, Default)]
pub struct HeldOutQueries {
    /// In rows.
    pub descriptors: Vec<f32>,
    /// The name of each row's grasp; nothing where that is not known.
    pub grasps: Vec<Arc<str>>,
}

fn cannot_use(path: &Path) -> String {
    format!("cannot use {}", path.display())
}

/// Views of hand shapes that a plan does not have, in its grasps, posed as differently as people
/// do, in varied light, from anywhere between its views.
#[derive(Clone, Debug)]
pub struct Hands {
    hand_shapes: Vec<HandShape>,
    /// How many of the shapes are seen in each grasp.
    a_grasp: usize,
    plan: RenderPlan,
    views: usize,
    seed: u64,
}

impl std::fmt::Display for Hands {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { views, seed, .. } = self;
        let names = self.names().join(", ");
        write!(f, "{views} views of {names}, seed {seed}, renderer {RENDERER_VERSION}")
    }
}

impl Hands {
    /// `hands` hand shapes beside those of `plan` and those `known`, and about `views` views of
    /// them.
    #[must_use]
    pub fn beside(plan: &RenderPlan, known: &[String], hands: usize, views: usize, seed: u64) -> Self {
        let is_new = |shape: &HandShape| !known.contains(&shape.name) && !plan.hand_shapes.contains(shape);
        let hand_shapes: Vec<_> = (FIRST_SEED..).map(HandShape::sample).filter(is_new).take(hands).collect();
        let look = Look {
            light_variation: plan.look.light_variation.max(LIGHT),
            distance_variation: plan.look.distance_variation.max(DISTANCE),
            ..plan.look.clone()
        };
        // The shapes that the views are not of are not needed.
        let plan = RenderPlan { hand_shapes: Vec::new(), hand_models: Vec::new(), look, ..plan.clone() };
        Self { a_grasp: hand_shapes.len(), hand_shapes, plan, views, seed }
    }

    /// The names of the hand shapes.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.hand_shapes.iter().map(|shape| shape.name.clone()).collect()
    }

    /// What a build measures its search by.
    #[must_use]
    pub fn of_a_build(plan: &RenderPlan, known: &[String], seed: u64) -> Self {
        Self { a_grasp: HANDS_A_GRASP, ..Self::beside(plan, known, HANDS, VIEWS, seed) }
    }

    /// The descriptors of all views that show a hand, in rows: grasp by grasp, hand by hand.
    ///
    /// # Errors
    /// When the work was interrupted.
    pub fn describe(&self, model: &DescriptorModel) -> anyhow::Result<HeldOutQueries> {
        let mut all = HeldOutQueries::default();
        for scenes in self.scenes().chunks(rayon::current_num_threads().max(1)) {
            interrupt::check()?;
            let described: Vec<Vec<f32>> = scenes
                .par_iter()
                .map(|(spec, views)| described(spec, views, model))
                .collect::<anyhow::Result<_>>()?;
            for ((spec, _), rows) in scenes.iter().zip(described) {
                let grasp: Arc<str> = spec.grasp.name.as_str().into();
                all.grasps.extend(std::iter::repeat_n(grasp, rows.len() / model.params().dim().max(1)));
                all.descriptors.extend(rows);
            }
        }
        Ok(all)
    }

    /// Each grasp by as many hands, in turn, at a stage drawn from the plan's and with an object of
    /// any size, and its share of the views.
    fn scenes(&self) -> Vec<(SceneSpec, Vec<View>)> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let plan = &self.plan;
        let count = self.a_grasp * plan.grasps.len();
        let hand_shapes: Vec<_> = self.hand_shapes.iter().cloned().map(Arc::new).collect();
        // Hands in an index may all be posed alike; those that it is asked for are not.
        let people = Variation::PEOPLE;
        let mut in_turn = hand_shapes.iter().cycle();
        let mut scenes = Vec::with_capacity(count);
        for grasp in plan.grasps.iter().cloned().map(Arc::new) {
            for shape in in_turn.by_ref().take(self.a_grasp) {
                let stage = rng.random_range(0..plan.stages.len().max(1) as u64) as usize;
                let size = rng.random_range(0.2..0.8);
                let spec = SceneSpec {
                    hand_shape: Arc::clone(shape),
                    hand_model: None,
                    grasp: Arc::clone(&grasp),
                    stage: plan.stages.get(stage).copied().unwrap_or(Stage::Grasp),
                    object: grasp.object.object(size),
                    example: None,
                    held: None,
                    look: plan.look.clone(),
                    // Another light than that of the index's own views from the same direction.
                    seed: plan.seed.wrapping_add(FIRST_SEED),
                };
                let spec = people.vary(spec);
                // So that they sum up to what is asked for.
                let at = scenes.len();
                let views = (at + 1) * self.views / count - at * self.views / count;
                let views = (0..views).map(|_| self.view(&mut rng)).collect();
                scenes.push((spec, views));
            }
        }
        scenes
    }

    fn view(&self, rng: &mut ChaCha8Rng) -> View {
        let height: f64 = rng.random_range(0.0..1.0);
        let azimuth_deg = rng.random_range(0.0..360.0);
        match &self.plan.views {
            Views::Grid(grid) => {
                let [low, high] = grid.elevation_deg;
                let roll = rng.random_range(0..grid.rolls_deg.len().max(1) as u64) as usize;
                let roll_deg = grid.rolls_deg.get(roll).copied().unwrap_or(0.0);
                View { azimuth_deg, elevation_deg: low + (high - low) * height, roll_deg }
            }
            Views::Random(_) => {
                let elevation_deg = libm::asin(2.0 * height - 1.0).to_degrees();
                View { azimuth_deg, elevation_deg, roll_deg: rng.random_range(0.0..360.0) }
            }
        }
    }
}

fn described(spec: &SceneSpec, views: &[View], model: &DescriptorModel) -> anyhow::Result<Vec<f32>> {
    let scene = spec.build().context("cannot render")?;
    let (params, mut describer) = (model.params(), model.describer());
    let mut rows = Vec::with_capacity(views.len() * params.dim());
    for view in views {
        let render = scene.render(view);
        if let Some(hand) = hand_in(render.side, render.side, &render.grey)? {
            rows.extend(describer.describe(&hand.shrunk_to(params.described_side())));
        }
    }
    Ok(rows)
}

/// `rows` rows of `dim` values, each moved along the difference of two others as far as
/// [`NOISE`] says: what to search an index of renders for, if
/// it is to be as far from its nearest neighbours as real pictures are.
#[must_use]
pub fn moved(values: &[f32], dim: usize, seed: u64) -> Vec<f32> {
    let rows: Vec<&[f32]> = values.chunks_exact(dim.max(1)).collect();
    let spaced: Vec<&[f32]> = rows.iter().copied().step_by(rows.len().div_ceil(PAIRED).max(1)).collect();
    let sigma = mean_distance(&spaced);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    let mut moved = Vec::with_capacity(values.len());
    for row in &rows {
        let [start, end] = [(); 2].map(|()| rows[rng.random_range(0..rows.len() as u64) as usize]);
        let length = rng.random_range(NOISE[0]..NOISE[1]) * sigma;
        moved.extend(moved_along(row, start, end, length as f32));
    }
    moved
}
