//! `grasp-query experiment robustness` and `experiment imitation`.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::simulated_hand::SimulatedHand;
use crate::experiment::imitation::Imitation;
use crate::experiment::robustness::{Progress, Robustness, Sweep};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_robot::simulation::{SCENES, Scene};

/// How far a robot's grasp may be off: trials on a grid of positions and over a range of yaws.
///
/// The object lies beside where the hand takes it to be, along the world's x and y (a side approach
/// comes along x), or the hand is turned about the vertical. With --out, DIR gets robustness.csv, a
/// line per trial, as they end: stopped and started again, the sweep goes on. windows.csv and
/// robustness.svg follow.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment robustness --out robustness
  grasp-query experiment robustness --object box --reach 20 --yaw 45 --json

Exit status: 0, or 2 where the sweep could not be run.")]
pub(super) struct RobustnessArguments {
    /// A built-in object (cylinder-upright, cylinder-lying, box, sphere, disc, block, stick,
    /// handle), with the grasp that is meant for it; may be repeated; without it, all.
    #[arg(long = "object", value_name = "NAME", value_parser = scene_named(), hide_possible_values = true)]
    objects: Vec<&'static Scene>,
    #[command(flatten)]
    robot: SimulatedHand,
    /// The greatest offset of the position in either direction, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 40, value_parser = clap::value_parser!(u32).range(0..=200))]
    reach: u32,
    /// The step between positions, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100))]
    step: u32,
    /// The greatest yaw in either direction, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 45, value_parser = clap::value_parser!(u32).range(0..=180))]
    yaw: u32,
    /// The step between yaws, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=90))]
    yaw_step: u32,
    /// Write table, windows and heat maps into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the windows as one JSON record.
    #[arg(long)]
    json: bool,
}

impl RobustnessArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let hand = self.robot.find()?;
        let scenes = if self.objects.is_empty() { SCENES.iter().collect() } else { self.objects.clone() };
        let sweep = Sweep {
            scenes,
            reach_mm: self.reach,
            step_mm: self.step,
            yaw_deg: self.yaw,
            yaw_step_deg: self.yaw_step,
        };
        let bar = global.progress().bar(0, "simulating", "trials");
        let robustness = Robustness::run(&hand, &sweep, self.out.as_deref(), |progress| match progress {
            Progress::Trials(count) => bar.set_length(count as u64),
            Progress::Ended => bar.inc(1),
        })?;
        drop(bar);
        if let Some(folder) = &self.out {
            robustness.write(folder)?;
        }
        print(self.json, &robustness, || robustness.text())?;
        Ok(SUCCESS)
    }
}

fn scene_named() -> impl TypedValueParser<Value = &'static Scene> {
    let names = PossibleValuesParser::new(SCENES.map(|scene| scene.name));
    names.try_map(|name| Scene::named(&name).ok_or_else(|| format!("no scene is named {name}")))
}

/// From pictures to lifted objects: what was recognised, with its real errors, is imitated in the
/// simulation.
///
/// Each labelled hand is put round an object that its grasp is for, turned by the error that its
/// recognition made, and the robot does what was recognised. The object's position is exact.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment imitation tests/pictures/labels.csv --hand right \\
    --where kind=segmented --where stage=grasp

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
pub(super) struct ImitationArguments {
    #[command(flatten)]
    index: IndexFile,
    #[command(flatten)]
    robot: SimulatedHand,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl ImitationArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let hand = self.robot.find()?;
        let index = self.index.open_for_pictures()?;
        let selected = self.labelled.read(&index)?;
        let outcomes = self.labelled.score(&selected, &index, self.labelled.recognise.options()?, global)?;
        let bar = global.progress().bar(outcomes.len() as u64, "simulating", "trials");
        let imitation = Imitation::new(&hand, &outcomes, &selected.broken, || bar.inc(1))?;
        drop(bar);
        print(self.labelled.json, &imitation, || imitation.text())?;
        Ok(if imitation.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
