//! What the frames before are worth: labelled pictures of one view of one grasp at several stages,
//! told one by one and in their order.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;
use std::path::Path;

use anyhow::bail;
use grasp_terminal::text::counted;
use serde::Serialize;

use super::{KINDS, csv_of, json_of, write_files};
use crate::evaluate::errors::median;
use crate::evaluate::labels::{Kind, Label, RowError};
use crate::evaluate::report::{Report, RowReport, errors_text};
use crate::evaluate::{Guess, Outcome};
use grasp_recognise::sequence::{Belief, Filter, SequenceParams, Turn};

/// The stages of a grasp in their order.
const STAGES: [&str; 3] = ["reach", "close", "grasp"];
/// What pictures of one sequence have in common.
const SAME: [&str; 6] = ["grasp", "hand", "azimuth", "elevation", "roll", "group"];
/// The columns without which pictures of different views would pass for one sequence.
const NEEDED: [&str; 4] = ["stage", "azimuth", "elevation", "roll"];

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Sequences {
    /// The table of labels.
    pub labels: String,
    /// The probability that the grasp changes from one frame to the next.
    pub switch: f64,
    /// How far the hand turns from one frame to the next, in degrees.
    pub motion_deg: f64,
    /// One row a kind of pictures and stage.
    pub rows: Vec<Row>,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

/// The frames of one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Segmented or camera.
    pub kind: String,
    /// The stage of the last frame.
    pub stage: &'static str,
    /// How many sequences.
    pub n: usize,
    /// The share that is classed rightly by this frame alone, 0..=1.
    pub alone_top1: f64,
    /// The same by all frames so far.
    pub together_top1: f64,
    /// The median angle between the labelled and the answered rotation by this frame alone, in
    /// degrees; null without labels.
    pub alone_median_deg: Option<f64>,
    /// The same by all frames so far.
    pub together_median_deg: Option<f64>,
}

/// One stage of one sequence: right or not, and the error, alone and together.
struct Scored {
    is_right: [bool; 2],
    error_deg: Option<[f64; 2]>,
}

impl Sequences {
    /// Puts the outcomes together that show one view of one grasp at all three stages; others are
    /// left out, and so is a sequence of which a picture could not be read.
    pub fn new(labels: String, outcomes: &[Outcome], broken: &[RowError], params: SequenceParams) -> Self {
        let rows = KINDS.iter().flat_map(|&kind| rows(kind, outcomes, params)).collect();
        let errors = Report::new(Vec::new(), outcomes, broken, false).errors;
        let SequenceParams { switch, motion_deg } = params;
        Self { labels, switch, motion_deg, rows, errors }
    }

    /// The figures as text.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if self.rows.is_empty() {
            text.push_str("no view of a grasp is labelled at all three stages reach, close and grasp\n");
        }
        for row in &self.rows {
            let degrees =
                |error: Option<f64>| error.map_or_else(String::new, |error| format!(", {error:.1}°"));
            let _ = writeln!(
                text,
                "{:<9} {:<5}  {}: alone {:.1} %{}; with the frames before {:.1} %{}",
                row.kind,
                row.stage,
                counted(row.n, ["sequence", "sequences"]),
                100.0 * row.alone_top1,
                degrees(row.alone_median_deg),
                100.0 * row.together_top1,
                degrees(row.together_median_deg),
            );
        }
        text.push_str(&errors_text(&self.errors));
        text
    }

    /// What [`Self::write`] writes.
    pub const FILES: [&str; 2] = ["sequence.csv", "sequence.json"];

    /// Writes [`Self::FILES`] into a folder, which is made where there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        write_files(folder, Self::FILES, [csv_of(&self.rows)?, json_of(self)?])
    }
}

/// Checks that labels say which pictures are one sequence.
///
/// # Errors
/// Where a column is missing that a view is told by, or two pictures show one view at one stage.
pub fn check(labels: &[Label]) -> anyhow::Result<()> {
    let mut seen: HashMap<Vec<&str>, &Label> = HashMap::new();
    for label in labels {
        if let Some(missing) = NEEDED.iter().find(|column| !label.columns.contains_key(**column)) {
            bail!("the labels have no column `{missing}`: a sequence is told by {}", NEEDED.join(", "));
        }
        if label.stage.is_empty() {
            continue;
        }
        let kind = if label.kind == Kind::Camera { "camera" } else { "segmented" };
        let view = SAME.iter().map(|name| label.columns.get(*name).map_or("", String::as_str));
        let place = view.chain([kind, label.stage.as_str()]).collect();
        if let Some(other) = seen.insert(place, label) {
            bail!(
                "lines {} and {} of the labels show one view of {} at the stage {}: give them different values in the \
                 column group",
                other.line,
                label.line,
                label.grasp,
                label.stage
            );
        }
    }
    Ok(())
}

fn rows(kind: Kind, outcomes: &[Outcome], params: SequenceParams) -> Vec<Row> {
    let mut views: BTreeMap<Vec<&str>, BTreeMap<usize, &Outcome>> = BTreeMap::new();
    for outcome in outcomes.iter().filter(|outcome| outcome.label.kind == kind) {
        let Some(stage) = STAGES.iter().position(|stage| *stage == outcome.label.stage) else { continue };
        let column = |name: &&str| outcome.label.columns.get(*name).map_or("", String::as_str);
        views.entry(SAME.iter().map(column).collect()).or_default().insert(stage, outcome);
    }
    let mut scored: [Vec<Scored>; 3] = Default::default();
    let is_whole = |frames: &&BTreeMap<usize, &Outcome>| {
        frames.len() == STAGES.len() && frames.values().all(|frame| frame.was_read())
    };
    for frames in views.values().filter(is_whole) {
        let mut filter = Filter::new(params, None);
        for (stage, outcome) in scored.iter_mut().zip(frames.values()) {
            stage.push(score(outcome, &mut filter));
        }
    }
    let stages = STAGES.iter().zip(&scored).filter(|(_, scored)| !scored.is_empty());
    stages.map(|(stage, scored)| row(kind, stage, scored)).collect()
}

fn score(outcome: &Outcome, filter: &mut Filter) -> Scored {
    let Ok(guess) = &outcome.result else {
        filter.pass();
        return Scored { is_right: [false; 2], error_deg: None };
    };
    let names = names(guess);
    let frame = Belief {
        classes: names.iter().map(|(_, probability)| *probability).collect(),
        side: guess.hand,
        turn: Turn { rotation: guess.orientation, spread_deg: guess.spread_deg },
    };
    let fused = filter.update(&frame);
    let is_right = |belief: &Belief| {
        let first = names.iter().zip(&belief.classes).max_by(|(_, a), (_, b)| a.total_cmp(b));
        first.is_some_and(|((name, _), _)| *name == outcome.label.grasp)
    };
    let error = |belief: &Belief| {
        outcome.label.orientation.map(|labelled| labelled.angle_to(&belief.turn.rotation).to_degrees())
    };
    Scored {
        is_right: [is_right(&frame), is_right(&fused)],
        error_deg: error(&frame).zip(error(&fused)).map(|(alone, together)| [alone, together]),
    }
}

/// The classes in the same order for every picture.
fn names(guess: &Guess) -> Vec<(&str, f64)> {
    let mut names: Vec<(&str, f64)> = guess.classes.iter().map(|(name, p)| (name.as_str(), *p)).collect();
    names.sort_by_key(|(name, _)| *name);
    names
}

fn row(kind: Kind, stage: &'static str, scored: &[Scored]) -> Row {
    let share = |which: usize| {
        scored.iter().filter(|scored| scored.is_right[which]).count() as f64 / scored.len() as f64
    };
    let median =
        |which: usize| median(scored.iter().filter_map(|scored| Some(scored.error_deg?[which])).collect());
    Row {
        kind: kind.to_string(),
        stage,
        n: scored.len(),
        alone_top1: share(0),
        together_top1: share(1),
        alone_median_deg: median(0),
        together_median_deg: median(1),
    }
}
