//! Which hands, objects and views to render: the options that `render` and `build` share, and that
//! an index keeps for what is added to it.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, bail};
use grasp_renders::{GraspSet, HandModel, HandShape, Preset, RenderPlan, Stage, ViewGrid, Views};
use grasp_terminal::text::shown;
use tracing::info;

use super::preset::preset;
use crate::plan_spec::{EXAMPLES, PlanSpec, ROLLS, STEPS_DEG, VIEWS, Version, are_elevations};

/// Views of one scene are held at a time; more than a million are a slip of the keyboard.
const MOST_VIEWS: f64 = 1e6;
/// The largest file of grasps in bytes, seventy times as large as that of the built-in ones: what
/// the parser makes of a text takes as many times its memory.
const LARGEST_GRASPS: usize = 1 << 20;

#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "What to render")]
pub(super) struct PlanOptions {
    /// A named plan, which the options below change. `standard`: 40 hand shapes at all stages, in
    /// varied poses, with objects of all sizes, seen from everywhere with any roll. `wide`: the
    /// same of 155 hand shapes, six times as many views. `paper`: one hand shape, 6 grasps, 900
    /// views on a grid; implied by --step, --elevations and --rolls.
    #[arg(long, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
    preset: Option<Preset>,
    /// Render N hand shapes: the mean hand, the named ones, then hands sampled from the human
    /// range; 0 beside --hand-model renders that hand alone.
    #[arg(long, value_name = "N", conflicts_with = "hand_shape", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    hands: Option<u32>,
    /// Render this hand shape (may be repeated): mean, small, large, slender, broad, long-fingered,
    /// short-fingered, or hand-SEED for a sampled one.
    #[arg(long, value_name = "NAME")]
    hand_shape: Vec<String>,
    /// Render this hand as well (may be repeated): a skinned mesh in a binary glTF file (.glb) with
    /// the joints of WebXR's hands, `wrist` to `pinky-finger-tip`. It is named after the file; a
    /// left hand is mirrored.
    #[arg(long, value_name = "FILE.glb")]
    hand_model: Vec<PathBuf>,
    /// Render this stage (may be repeated): reach, close, grasp.
    #[arg(long, value_name = "NAME")]
    stage: Vec<Stage>,
    /// Read the grasps from a file in the form of renders/data/grasps.toml.
    #[arg(long, value_name = "FILE")]
    grasps: Option<PathBuf>,
    /// Step between views in degrees, in azimuth and elevation.
    #[arg(long, value_name = "DEG", value_parser = parse_step, allow_negative_numbers = true)]
    step: Option<f64>,
    /// Elevations in degrees, e.g. 0..84, or -84..84 for both half-spheres.
    #[arg(long, value_name = "LOW..HIGH", value_parser = elevations, allow_hyphen_values = true)]
    elevations: Option<[f64; 2]>,
    /// Rolls about the optical axis, evenly spaced over the full turn.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(limits(ROLLS)))]
    rolls: Option<u32>,
    /// Instead of a grid, take N views of every scene, other ones for each: any azimuth, elevation
    /// and roll.
    #[arg(long, value_name = "N", conflicts_with_all = ["step", "elevations", "rolls"], value_parser = clap::value_parser!(u32).range(limits(VIEWS)))]
    views: Option<u32>,
    /// Pose this share of the scenes, 0 to 1, like the examples in the grasps' file; the rest close
    /// on their objects.
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    examples: Option<f64>,
    /// Distance of the camera, in hand lengths.
    #[arg(long, value_name = "LENGTHS", allow_negative_numbers = true)]
    distance: Option<f64>,
    /// Length of the bare forearm behind the wrist in millimetres, the same in all scenes; 0 cuts
    /// at the wrist. By default `standard` and `wide` draw arms of 0 to 160 mm, `paper` none.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    forearm: Option<f64>,
    /// How far the light may move from view to view, 0 to 1.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    light_variation: Option<f64>,
    /// How far the distance may vary from view to view, 0 to 0.5.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    distance_variation: Option<f64>,
    /// The grasps of an index, where no file of them is named.
    #[arg(skip)]
    kept_grasps: Option<String>,
}

impl PlanOptions {
    /// Those of a preset alone.
    pub(super) fn of_preset(preset: Option<Preset>) -> Self {
        Self { preset, ..Self::default() }
    }

    /// These options with a preset, where they name none.
    pub(super) fn otherwise(self, preset: Preset) -> Self {
        Self { preset: self.preset.or(Some(preset)), ..self }
    }

    /// The preset: the one that is named, or the one that these options fit.
    pub(super) fn preset(&self) -> Preset {
        let fits = if self.has_grid() { Preset::Paper } else { Preset::Standard };
        self.preset.unwrap_or(fits)
    }

    /// Whether any of the options of a grid of views is given.
    fn has_grid(&self) -> bool {
        self.step.is_some() || self.elevations.is_some() || self.rolls.is_some()
    }

    /// The option that says how many views there are, where one does.
    pub(super) fn views_option(&self) -> Option<&'static str> {
        let step = self.step.map(|_| "--step");
        step.or(self.views.map(|_| "--views"))
    }

    /// Whether a preset is named.
    pub(super) fn names_a_preset(&self) -> bool {
        self.preset.is_some()
    }

    /// What an index keeps of these options: how hands are posed and seen, with the text of a file
    /// of grasps. Whose hands they are is left out.
    ///
    /// # Errors
    /// Where the file of the grasps cannot be read.
    pub(super) fn spec(&self) -> anyhow::Result<PlanSpec> {
        Ok(PlanSpec {
            version: Version,
            preset: self.preset(),
            stages: self.stage.clone(),
            step_deg: self.step,
            elevations_deg: self.elevations,
            rolls: self.rolls,
            views: self.views,
            examples: self.examples,
            distance: self.distance,
            forearm_mm: self.forearm,
            light_variation: self.light_variation,
            distance_variation: self.distance_variation,
            grasps: self.grasps_text()?,
        })
    }

    /// These options, and where they say nothing, those of `kept`.
    pub(super) fn or(self, kept: PlanSpec) -> Self {
        let has_grid = self.has_grid();
        let (is_grid, is_random) = (has_grid || self.views.is_none(), self.views.is_some() || !has_grid);
        Self {
            preset: self.preset.or(Some(kept.preset)),
            stage: if self.stage.is_empty() { kept.stages } else { self.stage },
            step: self.step.or(kept.step_deg.filter(|_| is_grid)),
            elevations: self.elevations.or(kept.elevations_deg.filter(|_| is_grid)),
            rolls: self.rolls.or(kept.rolls.filter(|_| is_grid)),
            views: self.views.or(kept.views.filter(|_| is_random)),
            examples: self.examples.or(kept.examples),
            distance: self.distance.or(kept.distance),
            forearm: self.forearm.or(kept.forearm_mm),
            light_variation: self.light_variation.or(kept.light_variation),
            distance_variation: self.distance_variation.or(kept.distance_variation),
            kept_grasps: kept.grasps,
            ..self
        }
    }

    /// These options with the grasps that an index keeps, for where they name no file of any.
    pub(super) fn or_grasps(self, kept: Option<String>) -> Self {
        Self { kept_grasps: kept, ..self }
    }

    /// How many hand shapes are asked for.
    pub(super) fn hands(&self) -> Option<usize> {
        self.hands.map(|hands| hands as usize)
    }

    /// Whether hand shapes are named.
    pub(super) fn names_hand_shapes(&self) -> bool {
        !self.hand_shape.is_empty()
    }

    /// The grasps, which are also the classes of a render set.
    pub(super) fn grasps(&self) -> anyhow::Result<GraspSet> {
        let Some(text) = self.grasps_text()? else { return Ok(GraspSet::builtin()) };
        GraspSet::parse(&text).with_context(|| match &self.grasps {
            Some(path) => format!("cannot use the grasps of {}", path.display()),
            None => "cannot use the grasps that the index was built with".to_owned(),
        })
    }

    /// The grasps as they are written down, where they are not the built-in ones.
    fn grasps_text(&self) -> anyhow::Result<Option<String>> {
        let Some(path) = &self.grasps else { return Ok(self.kept_grasps.clone()) };
        let cannot = || format!("cannot read the grasps {}", path.display());
        let text = grasp_bounded::read_text(path).with_context(cannot)?;
        if text.len() > LARGEST_GRASPS {
            let (found, most) = (text.len() >> 10, LARGEST_GRASPS >> 10);
            bail!("the grasps {} are {found} KiB: files of at most {most} KiB are read", path.display());
        }
        Ok(Some(text))
    }

    /// The plan that the options describe.
    pub(super) fn plan(&self, seed: u64) -> anyhow::Result<RenderPlan> {
        let mut plan = RenderPlan::preset(self.preset());
        plan.seed = seed;
        if let Some(hands) = self.hands {
            plan = plan.with_hands(hands as usize);
        }
        if let Some(name) = repeated(&self.hand_shape) {
            bail!("--hand-shape {name} is named twice");
        }
        if let Some(stage) = repeated(&self.stage) {
            bail!("--stage {stage} is named twice");
        }
        if !self.hand_shape.is_empty() {
            plan.hand_shapes =
                self.hand_shape.iter().map(|name| HandShape::preset(name)).collect::<Result<_, _>>()?;
        }
        for path in &self.hand_model {
            let model = hand_model(path)?;
            let name = &model.shape().name;
            if plan.hand_models.iter().any(|other| other.shape().name == *name) {
                bail!("two files of --hand-model are named {name}: rename one");
            }
            if plan.hand_shapes.iter().any(|other| other.name == *name) {
                bail!("a hand shape is named {name} as well as a file of --hand-model: rename the file");
            }
            plan.hand_models.push(Arc::new(model));
        }
        if plan.hand_shapes.is_empty() && plan.hand_models.is_empty() {
            bail!("--hands 0 leaves no hand to render: add --hand-model FILE.glb");
        }
        if !self.stage.is_empty() {
            plan.stages.clone_from(&self.stage);
        }
        plan.grasps = self.grasps()?;
        plan.views = self.views(plan.views)?;
        if let Some(share) = self.examples {
            plan.variation.examples = share;
        }
        let look = &mut plan.look;
        look.distance = self.distance.unwrap_or(look.distance);
        if let Some(millimetres) = self.forearm {
            if !(0.0..=400.0).contains(&millimetres) {
                bail!("--forearm {millimetres}: 0 to 400 millimetres are possible");
            }
            look.forearm = millimetres / 1000.0;
            plan.variation.forearm = None;
        }
        look.light_variation = self.light_variation.unwrap_or(look.light_variation);
        look.distance_variation = self.distance_variation.unwrap_or(look.distance_variation);
        if plan.renders() == 0 {
            bail!("these options leave no view to render: widen --elevations");
        }
        Ok(plan)
    }

    /// The preset's views, changed by the options: any of those of a grid makes it one.
    fn views(&self, preset: Views) -> anyhow::Result<Views> {
        if let Some(count) = self.views {
            return Ok(Views::Random(count as usize));
        }
        let mut grid = match preset {
            Views::Random(_) if !self.has_grid() => return Ok(preset),
            Views::Random(_) => ViewGrid { elevation_deg: [-84.0, 84.0], ..ViewGrid::default() },
            Views::Grid(grid) => grid,
        };
        grid.step_deg = self.step.unwrap_or(grid.step_deg);
        grid.elevation_deg = self.elevations.unwrap_or(grid.elevation_deg);
        if let Some(rolls) = self.rolls {
            grid.rolls_deg = (0..rolls).map(|i| f64::from(i) * 360.0 / f64::from(rolls)).collect();
        }
        let [low, high] = grid.elevation_deg;
        let directions = (360.0 / grid.step_deg).ceil() * ((high - low) / grid.step_deg + 1.0);
        let views = directions * grid.rolls_deg.len() as f64;
        if views > MOST_VIEWS {
            bail!(
                "{views:.0} views of each scene are too many: widen --step or lower --rolls (at most {MOST_VIEWS:.0})"
            );
        }
        Ok(Views::Grid(grid))
    }
}

pub(super) fn hand_model(path: &Path) -> anyhow::Result<HandModel> {
    let model =
        HandModel::load(path).with_context(|| format!("cannot use the hand of {}", path.display()))?;
    if model.was_left() {
        info!("{} is a left hand by its thumb: it is mirrored", shown(path));
    }
    Ok(model)
}

/// The limits of a count, as clap wants them.
fn limits(counts: RangeInclusive<u32>) -> RangeInclusive<i64> {
    i64::from(*counts.start())..=i64::from(*counts.end())
}

/// A step between views, in degrees.
pub(super) fn parse_step(text: &str) -> Result<f64, String> {
    let step = text.parse().ok().filter(|step| STEPS_DEG.contains(step));
    let (least, most) = (STEPS_DEG.start(), STEPS_DEG.end());
    step.ok_or_else(|| format!("a step must lie between {least} and {most} degrees"))
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| EXAMPLES.contains(share));
    share.ok_or_else(|| format!("`{text}` is not a number from 0 to 1"))
}

fn elevations(text: &str) -> Result<[f64; 2], String> {
    let form = || format!("`{text}` is not a range of elevations: write LOW..HIGH, e.g. -84..84");
    let (low, high) = text.split_once("..").ok_or_else(form)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| form());
    let range = [number(low)?, number(high)?];
    if !are_elevations(range) {
        return Err(format!(
            "`{text}`: elevations lie between -90 and 90 degrees, and LOW is not above HIGH"
        ));
    }
    Ok(range)
}

/// The first value that is there before.
fn repeated<T: PartialEq>(values: &[T]) -> Option<&T> {
    values.iter().enumerate().find(|(at, value)| values[..*at].contains(value)).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Line {
        #[command(flatten)]
        options: PlanOptions,
    }

    fn options(line: &str) -> PlanOptions {
        Line::try_parse_from(line.split(' ')).expect("these are options").options
    }

    #[test]
    fn an_index_keeps_what_makes_the_same_plan() {
        for line in [
            "--preset=paper",
            "--preset=wide --stage=reach --stage=grasp",
            "--preset=wide --elevations=-84..84 --rolls=7 --step=51.42857142857143",
            "--preset=paper --views=3 --examples=0.1 --distance=3.7 --forearm=33.3 --light-variation=0.3 --distance-variation=0.07",
        ] {
            let kept = options(line).spec().unwrap();
            let read: PlanSpec = kept.to_string().parse().unwrap();
            assert_eq!(read, kept);
            // What earlier builds wrote for the same options.
            assert_eq!(line.parse::<PlanSpec>().unwrap(), kept);
            let again = PlanOptions::default().or(read);
            assert_eq!(options(line).plan(3).unwrap(), again.plan(3).unwrap());
        }
        let foreign = options("--preset=paper --hand-model=x.glb --hands=9");
        assert_eq!(foreign.spec().unwrap(), PlanSpec::of_preset(Preset::Paper));
    }

    #[test]
    fn a_file_of_grasps_is_read_where_it_is_not_too_large_to_be_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grasps.toml");
        let grasps = PlanOptions { grasps: Some(path.clone()), ..PlanOptions::default() };
        let sound = include_str!("../../../renders/data/grasps.toml");
        std::fs::write(&path, sound).unwrap();
        assert_eq!(grasps.grasps().unwrap(), GraspSet::builtin());
        // As TOML these would be sixty times as large.
        std::fs::write(&path, format!("a = [{}]", "[],".repeat(LARGEST_GRASPS))).unwrap();
        let error = grasps.grasps().unwrap_err().to_string();
        assert!(error.ends_with("are 3072 KiB: files of at most 1024 KiB are read"), "{error}");
    }

    #[test]
    fn an_option_changes_the_preset_that_it_stands_beside() {
        let forearms = |line: &str| -> Vec<f64> {
            let plan = options(line).plan(0).unwrap().with_hands(1);
            plan.scenes().iter().map(|scene| scene.look.forearm).collect()
        };
        assert!(forearms("--preset=wide --forearm=50").iter().all(|metres| *metres == 0.05));
        assert!(forearms("--preset=wide").windows(2).any(|pair| pair[0] != pair[1]));
        assert_eq!(options("--step=30").preset(), Preset::Paper);
        assert_eq!(options("--preset=wide --step=30").preset(), Preset::Wide);
        assert_eq!(options("--hands=9").preset(), Preset::Standard);
    }

    #[test]
    fn what_is_said_now_goes_before_what_was_said_then() {
        let or = |own: &str, kept: &str| options(own).or(options(kept).spec().unwrap()).spec().unwrap();
        let is = |line: &str| options(line).spec().unwrap();
        let kept = "--preset=wide --stage=grasp --views=9 --forearm=20";
        assert_eq!(or("--forearm=0", kept), is("--preset=wide --stage=grasp --views=9 --forearm=0"));
        assert_eq!(or("--step=30", kept), is("--preset=wide --stage=grasp --step=30 --forearm=20"));
        let grid = "--preset=paper --rolls=2 --step=60";
        assert_eq!(or("--views=4 --stage=reach", grid), is("--preset=paper --stage=reach --views=4"));
        assert_eq!(or("--step=30", grid), is("--preset=paper --rolls=2 --step=30"));
    }
}
