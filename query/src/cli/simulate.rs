//! `grasp-query simulate`.

mod strip;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_terminal::text::{fixed, printable};
use serde::Serialize;

use grasp_answer::explain::{self, Format, SaveError};
use grasp_robot::simulation::{Offset, Outcome, Plan, Quality, SCENES, Scene};
use grasp_robot::{ApproachSide, Object};
use strip::strip;

use super::name_or_file::NameOrFile;
use super::outputs::check_file;
use super::simulated_hand::SimulatedHand;
use grasp_program::status::SUCCESS;

/// Try a robot's grasp in a physics engine: is the object lifted, does it slip, how hard is it
/// pressed?
///
/// The hand approaches, closes, lifts by 150 mm and holds. The trial is a success where the object
/// came up by more than 100 mm and moved by less than 10 mm in the hand while it was held.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query simulate --grasp wrap
  grasp-query simulate --grasp pinch --pictures pinch.png          a human grasp names the robot's
  grasp-query simulate --grasp wrap --object box --yaw 20 --y 15   the hand is off by 20° and 15 mm
  grasp-query simulate --grasp wrap --object query/data/objects/bottle.toml --from side --quality

Built-in objects: cylinder-upright, cylinder-lying, box, sphere, disc, block, stick, handle.

Exit status: 0 it holds, 1 it does not, 2 an error.")]
pub(super) struct Simulate {
    /// The grasp: wrap, two-finger-thumb, precision-disc, or a human grasp that is mapped to one of
    /// them.
    #[arg(long, value_name = "NAME")]
    grasp: String,
    /// The object: a built-in one, or an OBJECT.toml; without it, one that the grasp is meant for.
    #[arg(long, value_name = "OBJECT", value_parser = NameOrFile::new(SCENES.iter().map(|scene| scene.name)), hide_possible_values = true)]
    object: Option<String>,
    /// From where the hand comes; without it, from the side that a built-in object is meant for,
    /// and from above for others.
    #[arg(long, value_enum)]
    from: Option<FromArgument>,
    #[command(flatten)]
    robot: SimulatedHand,
    /// How far the object lies from where the hand expects it, along the world's x, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_millimetres)]
    x: f64,
    /// The same along y.
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_millimetres)]
    y: f64,
    /// How far the hand is turned about the vertical, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_degrees)]
    yaw: f64,
    /// Draw the trial as a strip of frames.
    #[arg(long, value_name = "OUT.png")]
    pictures: Option<PathBuf>,
    /// Say how good the grasp is: the acceleration at which the object slips when it is shaken, and
    /// Ferrari and Canny's epsilon.
    #[arg(long)]
    quality: bool,
    /// Print one JSON record.
    #[arg(long)]
    json: bool,
}

/// `--from`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FromArgument {
    /// From above; the palm's x is the world's, the fingers close along y.
    Top,
    /// Along the world's x; the fingers close along y.
    Side,
}

impl FromArgument {
    fn approach(self) -> ApproachSide {
        match self {
            Self::Top => ApproachSide::Top,
            Self::Side => ApproachSide::Side,
        }
    }
}

#[derive(Serialize)]
struct Record<'a> {
    robot: &'a str,
    grasp: &'a str,
    object: &'a str,
    error: Offset,
    #[serde(flatten)]
    outcome: &'a Outcome,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<Quality>,
}

impl Simulate {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        let hand = self.robot.find()?;
        let grasp = hand.for_human(&self.grasp).map_or(self.grasp.as_str(), |(name, _)| name);
        hand.grasp_named(grasp)?;
        let (object, from) = self.setting(grasp)?;
        let plan = Plan::new(&hand, grasp, &object, self.from.map_or(from, FromArgument::approach).turned())?;
        if let Some(path) = &self.pictures {
            Format::from_path(path).ok_or_else(|| SaveError::Format(path.clone()))?;
            check_file(path, [])?;
        }
        let offset = Offset { x: 1e-3 * self.x, y: 1e-3 * self.y, yaw: self.yaw.to_radians() };
        let outcome = match &self.pictures {
            None => plan.run(offset),
            Some(path) => {
                let (outcome, film) = plan.film(offset);
                explain::save(&strip(&film), path)
                    .with_context(|| format!("cannot write {}", path.display()))?;
                outcome
            }
        };
        let quality = self.quality.then(|| plan.quality(offset)).flatten();
        let record = Record {
            robot: &hand.name,
            grasp,
            object: &object.name,
            error: offset,
            outcome: &outcome,
            quality,
        };
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &record).map_err(io::Error::from)?;
            writeln!(out)?;
        } else {
            write!(out, "{}", text(&record))?;
        }
        Ok(if outcome.success { SUCCESS } else { 1 })
    }

    fn setting(&self, grasp: &str) -> anyhow::Result<(Object, ApproachSide)> {
        let scene = match &self.object {
            None => {
                Scene::for_human(&self.grasp).or_else(|| SCENES.iter().find(|scene| scene.grasp == grasp))
            }
            Some(name) if name.ends_with(".toml") => {
                let object = Object::read(Path::new(name))?;
                return Ok((object, ApproachSide::Top));
            }
            Some(name) => Scene::named(name),
        };
        let Some(scene) = scene else {
            let known: Vec<&str> = SCENES.iter().map(|scene| scene.name).collect();
            bail!("--object needs one of {}, or a file that describes one, as OBJECT.toml", known.join(", "));
        };
        Ok((scene.object()?, scene.from))
    }
}

fn text(record: &Record<'_>) -> String {
    let outcome = record.outcome;
    let verdict = match (outcome.success, outcome.lifted) {
        (true, _) => "holds",
        (false, true) => "slips",
        (false, false) => "not lifted",
    };
    let mut text = format!(
        "{} of {} on {}: {verdict} · rose {} mm, slipped {} mm, pushed {} mm while closing\n    \
         pressed with {} N in all, {} N by one link ({}) · {:.2} s simulated\n",
        record.grasp,
        printable(record.robot),
        printable(record.object),
        fixed(outcome.rise_mm, 0),
        fixed(outcome.slip_mm, 1),
        fixed(outcome.pushed_mm, 1),
        fixed(outcome.contact_force_n, 0),
        fixed(outcome.greatest_force_n, 0),
        if outcome.links.is_empty() { "nothing touches".into() } else { outcome.links.join(", ") },
        outcome.seconds,
    );
    if let Some(quality) = &record.quality {
        let shake = quality
            .shake_m_s2
            .map_or("slips at no acceleration up to 1000 m/s²".into(), |a| format!("slips at {a:.0} m/s²"));
        text += &format!("    shaken: {shake} · epsilon at most {:.3}\n", quality.epsilon);
    }
    text
}

fn parse_millimetres(text: &str) -> Result<f64, String> {
    parse_within(text, 500.0)
}

fn parse_degrees(text: &str) -> Result<f64, String> {
    parse_within(text, 180.0)
}

fn parse_within(text: &str, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.abs() <= most);
    number.ok_or_else(|| format!("a number from -{most} to {most} is needed"))
}
