//! Entries rendered on the fly.

use std::ops::Range;

use anyhow::Context as _;
use grasp_canonical::Encoder;
use grasp_index::{ClassInfo, Describer, NewEntry};
use grasp_renders::render_set::render_file;
use grasp_renders::{RenderPlan, Scene, SceneSpec, View, world_from_hand};
use rayon::prelude::*;

use super::described::{Described, Grey, Take, complete};
use super::known::Known;
use super::names::Names;
use super::recipe::Recipe;

/// Scenes that are meshed and held at a time: enough to keep the cores busy, few enough for any
/// memory.
const SCENES_AT_ONCE: usize = 16;

pub(super) fn names(plan: &RenderPlan) -> anyhow::Result<Names> {
    let classes = plan.grasps.iter();
    let classes = classes.map(|grasp| ClassInfo { name: grasp.name.clone(), cutkosky: grasp.cutkosky });
    let mut names = Names { classes: classes.collect(), ..Names::default() };
    names.sort_classes();
    for shape in &plan.hand_shapes {
        names.add_hand_shape(&shape.name)?;
    }
    for model in &plan.hand_models {
        names.add_hand_shape(&model.shape().name)?;
    }
    for stage in &plan.stages {
        names.add_stage(stage.name())?;
    }
    Ok(names)
}

/// Describes the renders of some of the plan's scenes, scene by scene, and hands the results to
/// `take` in order.
pub(super) fn describe(
    plan: &RenderPlan,
    names: &Names,
    recipe: &Recipe,
    known: &Known,
    pieces: Range<usize>,
    take: Take<'_>,
) -> anyhow::Result<()> {
    for specs in plan.scenes().get(pieces).unwrap_or(&[]).chunks(SCENES_AT_ONCE) {
        // A scene all of whose views are known need not be built.
        let scenes: Vec<Option<Scene>> = specs
            .par_iter()
            .map(|spec| {
                let hash = spec.params_hash();
                let all_known = plan.views(spec).iter().all(|view| known.contains(source_hash(hash, view)));
                if all_known { Ok(None) } else { spec.build().map(Some) }
            })
            .collect::<Result<_, _>>()
            .context("cannot render")?;
        for (spec, scene) in specs.iter().zip(&scenes) {
            take(describe_scene(plan, names, recipe, known, spec, scene.as_ref())?)?;
        }
    }
    Ok(())
}

/// Describes the views of one scene, which is there unless all of them are known.
fn describe_scene(
    plan: &RenderPlan,
    names: &Names,
    recipe: &Recipe,
    known: &Known,
    spec: &SceneSpec,
    scene: Option<&Scene>,
) -> anyhow::Result<Vec<Described>> {
    let template = template(spec, names)?;
    let hash = spec.params_hash();
    let describe = |describer: &mut Describer, view: &View| {
        let entry = NewEntry {
            file: render_file(spec, view),
            azimuth_deg: view.azimuth_deg as f32,
            elevation_deg: view.elevation_deg as f32,
            roll_deg: view.roll_deg as f32,
            orientation: view.camera_from_world() * world_from_hand(&spec.grasp.up),
            source_hash: source_hash(hash, view),
            ..template.clone()
        };
        complete(entry, recipe, describer, known, || {
            let render = scene.context("a scene that is needed was not built")?.render(view);
            Ok(Grey { width: render.side, height: render.side, pixels: render.grey })
        })
    };
    plan.views(spec).par_iter().map_init(|| recipe.descriptor.describer(), describe).collect()
}

/// A number for the plan: all its scenes, and its views of them.
pub(super) fn digest(plan: &RenderPlan) -> u64 {
    let mut to = Encoder::new();
    plan.scenes().iter().for_each(|scene| {
        to.u64(scene.params_hash());
    });
    to.value(&plan.views).hash()
}

/// What all entries of a scene share.
fn template(spec: &SceneSpec, names: &Names) -> anyhow::Result<NewEntry> {
    Ok(NewEntry {
        class: names.class(&spec.grasp.name)?,
        stage: names.stage(spec.stage.name())?,
        hand_shape: names.hand_shape(&spec.hand_shape.name)?,
        object: spec.object.name(),
        ..NewEntry::default()
    })
}

/// What a render's pixels follow from: the scene's parameters and the view.
fn source_hash(scene: u64, view: &View) -> u64 {
    Encoder::new().u64(scene).value(view).hash()
}
