//! The figures of an evaluation, as JSON and as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use grasp_index::euler_deg;
use grasp_terminal::text::{counted, printable};
use serde::Serialize;

use super::calibration::CalibrationReport;
use super::confusion::{Confusion, Share};
use super::errors::{Errors, errors, mean};
use super::labels::{Kind, OTHER, RowError};
use super::spread::SpreadReport;
use super::{Guess, Outcome};
use grasp_answer::record::UNKNOWN;

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Pictures with one of the index's classes for a label that could be read.
    pub n: usize,
    /// The share of them that was classed rightly; a picture without an answer counts as wrong.
    pub top1: f64,
    /// The same by class.
    pub per_class: BTreeMap<String, Share>,
    /// The same by stage.
    pub per_stage: BTreeMap<String, Share>,
    /// The same by kind of picture.
    pub per_kind: BTreeMap<String, Share>,
    /// The same by the table's `group`, where it has few of them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub per_group: BTreeMap<String, Share>,
    /// The same by the labelled hand.
    pub per_hand: BTreeMap<String, Share>,
    /// Whether probabilities come true.
    pub calibration: CalibrationReport,
    /// Which class was taken for which.
    pub confusion: Confusion,
    /// The angle between labelled and answered rotation, in degrees.
    pub orientation_error_deg: Errors,
    /// The same over rightly classed pictures alone.
    pub orientation_error_deg_right_class: Errors,
    /// Whether the neighbours' disagreement foretells it.
    pub spread: SpreadReport,
    /// The paper's Figure 8: the mean absolute difference of each Euler angle (x, y, z), in
    /// degrees.
    pub euler_error_deg: Option<[f64; 3]>,
    /// The share of pictures whose labelled hand was recognised, where it was left to the program.
    pub hand_right: Option<f64>,
    /// Pictures in which no hand was found, or whose class is unknown.
    pub unknown: usize,
    /// Pictures labelled `other`: in none of the classes. They are neither right nor wrong, and
    /// count elsewhere only where probabilities are stated high, in masks and in time.
    pub other: Other,
    /// Mean overlap of the segmentation with labelled masks.
    pub segmentation: Option<SegmentationReport>,
    /// Mean time a picture, decoding included, on one core, in milliseconds.
    pub ms_per_picture: f64,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

impl RowReport {
    /// The broken rows of another table than the one that was asked for.
    pub fn of_table(table: &Path, broken: &[RowError]) -> impl Iterator<Item = Self> {
        let file = table.display().to_string();
        broken.iter().map(move |row| Self {
            line: row.line,
            file: Some(file.clone()),
            message: row.fault.to_string(),
        })
    }
}

impl From<&RowError> for RowReport {
    fn from(row: &RowError) -> Self {
        Self { line: row.line, file: None, message: row.fault.to_string() }
    }
}

/// What became of pictures that show none of the classes.
#[derive(Clone, Debug, Serialize)]
pub struct Other {
    /// How many there are.
    pub n: usize,
    /// How many of them were not taken for one.
    pub unknown: usize,
    /// The mean probability of what they were taken for.
    pub mean_probability: Option<f64>,
}

/// Overlap of segmentation and labelled masks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SegmentationReport {
    /// Pictures with a labelled mask.
    pub n: usize,
    /// Mean intersection over union of skin, forearm included.
    pub mean_iou_skin: f64,
    /// Mean intersection over union of the hand, cut at the wrist.
    pub mean_iou_hand: f64,
}

/// A row that could not be used.
#[derive(Clone, Debug, Serialize)]
pub struct RowReport {
    /// The line of the table.
    pub line: u64,
    /// The picture, where it is known.
    pub file: Option<String>,
    /// What is wrong.
    pub message: String,
}

const PICTURES: [&str; 2] = ["picture", "pictures"];

/// More groups than this are no grouping but a list.
const MOST_GROUPS: usize = 24;

impl Report {
    /// Sums up outcomes over an index with `classes`, and the rows that could not be read.
    pub fn new<'a>(
        classes: Vec<String>,
        outcomes: impl IntoIterator<Item = &'a Outcome>,
        broken: &[RowError],
        hand_is_free: bool,
    ) -> Self {
        let mut errors: Vec<RowReport> = broken.iter().map(RowReport::from).collect();
        let mut usable = Vec::new();
        for outcome in outcomes {
            match &outcome.result {
                Err(miss) if !miss.is_rejection => errors.push(RowReport {
                    line: outcome.label.line,
                    file: Some(outcome.label.file.clone()),
                    message: miss.message.clone(),
                }),
                _ => usable.push(outcome),
            }
        }
        let (other, scored): (Vec<&Outcome>, Vec<&Outcome>) =
            usable.iter().copied().partition(|outcome| outcome.label.grasp == OTHER);

        let mut confusion = Confusion::new(classes);
        for outcome in &scored {
            confusion.add(&outcome.label.grasp, outcome.guess().map(|guess| guess.grasp.as_str()));
        }
        let mut per_group = shares(&scored, |o| o.label.columns.get("group").cloned().unwrap_or_default());
        if per_group.len() > MOST_GROUPS {
            per_group.clear();
        }
        let all = shares(&scored, |_| "all".into()).remove("all").unwrap_or_default();
        Self {
            n: scored.len(),
            top1: all.top1(),
            per_class: confusion.per_class(),
            per_stage: shares(&scored, |o| o.label.stage.clone()),
            per_kind: shares(&scored, |o| match o.label.kind {
                Kind::Segmented => "segmented".into(),
                Kind::Camera => "camera".into(),
            }),
            per_group,
            per_hand: shares(&scored, |o| o.label.hand.map(|hand| hand.to_string()).unwrap_or_default()),
            calibration: CalibrationReport::new(&scored, &usable),
            confusion,
            orientation_error_deg: angles(scored.iter().copied()),
            orientation_error_deg_right_class: angles(scored.iter().copied().filter(|o| o.is_right())),
            spread: SpreadReport::new(&scored),
            euler_error_deg: euler_errors(&scored),
            hand_right: if hand_is_free { hand_right(&scored) } else { None },
            unknown: scored.iter().filter(|outcome| outcome.is_unknown()).count(),
            other: Other {
                n: other.len(),
                unknown: other.iter().filter(|outcome| outcome.is_unknown()).count(),
                mean_probability: mean(other.iter().filter_map(|o| o.guess()).map(|g| g.probability)),
            },
            segmentation: segmentation(&usable),
            ms_per_picture: mean(usable.iter().map(|outcome| outcome.ms)).unwrap_or(0.0),
            errors,
        }
    }
}

impl Outcome {
    pub(super) fn guess(&self) -> Option<&Guess> {
        self.result.as_ref().ok()
    }

    /// Whether no class was answered.
    pub fn is_unknown(&self) -> bool {
        self.guess().is_none_or(|guess| guess.grasp == UNKNOWN)
    }

    /// Whether the picture, and its mask, could be read: where not, nothing is known of it.
    pub fn was_read(&self) -> bool {
        self.result.as_ref().err().is_none_or(|miss| miss.is_rejection)
    }

    /// Whether the labelled class was answered.
    pub fn is_right(&self) -> bool {
        self.guess().is_some_and(|guess| guess.grasp == self.label.grasp)
    }

    /// The full angle between labelled and answered rotation, in degrees; `None` where either is
    /// missing.
    pub fn orientation_error_deg(&self) -> Option<f64> {
        let labelled = self.label.orientation?;
        Some(self.guess()?.orientation.angle_to(&labelled).to_degrees())
    }
}

/// Shares by a key; pictures with an empty key count nowhere.
fn shares(outcomes: &[&Outcome], key: impl Fn(&Outcome) -> String) -> BTreeMap<String, Share> {
    let mut shares: BTreeMap<String, Share> = BTreeMap::new();
    for outcome in outcomes {
        let key = key(outcome);
        if !key.is_empty() {
            let share = shares.entry(key).or_default();
            share.n += 1;
            share.right += usize::from(outcome.is_right());
        }
    }
    shares
}

fn angles<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Errors {
    errors(outcomes.filter_map(Outcome::orientation_error_deg).collect())
}

/// The difference of two angles the short way round, 0..=180 degrees.
fn between(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

fn euler_errors(outcomes: &[&Outcome]) -> Option<[f64; 3]> {
    let pairs: Vec<([f64; 3], [f64; 3])> = outcomes
        .iter()
        .filter_map(|o| Some((euler_deg(&o.label.orientation?), euler_deg(&o.guess()?.orientation))))
        .collect();
    let axis = |n: usize| mean(pairs.iter().map(|(a, b)| between(a[n], b[n])));
    Some([axis(0)?, axis(1)?, axis(2)?])
}

fn hand_right(outcomes: &[&Outcome]) -> Option<f64> {
    mean(outcomes.iter().filter_map(|o| Some(f64::from(u8::from(o.guess()?.hand == o.label.hand?)))))
}

fn segmentation(outcomes: &[&Outcome]) -> Option<SegmentationReport> {
    let scores: Vec<_> = outcomes.iter().filter_map(|outcome| outcome.iou).collect();
    Some(SegmentationReport {
        n: scores.len(),
        mean_iou_skin: mean(scores.iter().map(|iou| iou.skin))?,
        mean_iou_hand: mean(scores.iter().map(|iou| iou.hand))?,
    })
}

/// The report for a person.
pub fn text(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_text(&mut text, report);
    text
}

fn write_text(text: &mut String, report: &Report) -> std::fmt::Result {
    if report.n == 0 {
        writeln!(text, "no picture that was answered shows one of the classes")?;
    } else {
        writeln!(
            text,
            "top-1 {:.1} % of {}, {} unknown or without a hand",
            100.0 * report.top1,
            counted(report.n, PICTURES),
            report.unknown
        )?;
    }
    let groups = [
        ("class", &report.per_class),
        ("stage", &report.per_stage),
        ("kind", &report.per_kind),
        ("group", &report.per_group),
        ("hand", &report.per_hand),
    ];
    for (name, shares) in groups.into_iter().filter(|(_, shares)| !shares.is_empty()) {
        writeln!(text, "\nby {name}")?;
        for (key, share) in shares {
            writeln!(text, "  {:<16} {:5.1} %  of {}", printable(key), 100.0 * share.top1(), share.n)?;
        }
    }
    if report.n > 0 {
        writeln!(text, "\nconfusion (rows: labelled; columns: answered)")?;
        report.confusion.write_text(text)?;
        writeln!(text)?;
        report.calibration.write_text(text)?;
    }
    orientation_text(text, "orientation error", &report.orientation_error_deg)?;
    orientation_text(text, "  of the right class", &report.orientation_error_deg_right_class)?;
    report.spread.write_text(text)?;
    if let Some([x, y, z]) = report.euler_error_deg {
        writeln!(text, "  by Euler angle: mean {x:.1}°, {y:.1}°, {z:.1}° about x, y, z")?;
    }
    if let Some(hand) = report.hand_right {
        writeln!(text, "left or right hand recognised correctly: {:.1} %", 100.0 * hand)?;
    }
    if let Some(found) = &report.segmentation {
        writeln!(
            text,
            "segmentation: mean IoU {:.3} with forearm, {:.3} of the hand alone, {}",
            found.mean_iou_skin,
            found.mean_iou_hand,
            counted(found.n, ["mask", "masks"])
        )?;
    }
    if report.other.n > 0 {
        let probability = report.other.mean_probability;
        writeln!(
            text,
            "{} none of the classes: {} unknown{}",
            counted(report.other.n, ["picture shows", "pictures show"]),
            report.other.unknown,
            probability.map_or_else(String::new, |mean| format!(", mean probability {mean:.2}"))
        )?;
    }
    writeln!(text, "{:.2} ms a picture", report.ms_per_picture)?;
    text.push_str(&errors_text(&report.errors));
    Ok(())
}

/// A line for each row that could not be used.
pub fn errors_text(errors: &[RowReport]) -> String {
    let line = |row: &RowReport| {
        let file = printable(row.file.as_deref().unwrap_or("the table"));
        format!("line {}: {file}: {}\n", row.line, printable(&row.message))
    };
    errors.iter().map(line).collect()
}

fn orientation_text(text: &mut String, name: &str, errors: &Errors) -> std::fmt::Result {
    match (errors.mean, errors.median) {
        (Some(mean), Some(median)) => {
            writeln!(text, "{name}: mean {mean:.1}°, median {median:.1}° over {}", errors.n)
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_differ_the_short_way_round() {
        assert_eq!(between(179.0, -179.0), 2.0);
        assert_eq!(between(-90.0, 90.0), 180.0);
        assert_eq!(between(10.0, 350.0), 20.0);
    }
}
