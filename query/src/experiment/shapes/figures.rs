//! The figures, summed up from what indexes made of the pictures.

use std::fmt::Write as _;

use serde::Serialize;

use crate::evaluate::Outcome;
use crate::evaluate::labels::{Kind, OTHER, RowError};
use crate::evaluate::report::{Report, RowReport, errors_text};
use crate::experiment::KINDS;

/// From the easiest to the hardest.
pub(super) const STAGES: [&str; 3] = ["grasp", "close", "reach"];

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Shapes {
    /// The table of labels.
    pub labels: String,
    /// Classes that a picture is taken for one of.
    pub classes: usize,
    /// The scores, by kind of picture, stage and number of hand shapes.
    pub points: Vec<Point>,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

/// The score of one index on the pictures of one kind and stage. Columns are an interface, like
/// keys.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Segmented or camera pictures.
    pub kind: Kind,
    /// How far the grasp is closed.
    pub stage: &'static str,
    /// Hand shapes of the index.
    pub hand_shapes: usize,
    /// Its entries.
    pub entries: usize,
    /// Pictures.
    pub n: usize,
    /// The share of them that was classed rightly, 0..=1.
    pub top1: f64,
    /// Where the true share begins, with 95 % confidence.
    pub top1_low: f64,
    /// Where it ends.
    pub top1_high: f64,
    /// The median angle between labelled and answered rotation, in degrees.
    pub orientation_median_deg: Option<f64>,
    /// Its mean.
    pub orientation_mean_deg: Option<f64>,
    /// The index.
    pub index: String,
}

/// An index and what it made of the pictures.
#[derive(Clone, Debug)]
pub struct Scored {
    /// Its file.
    pub index: String,
    /// Its hand shapes.
    pub hand_shapes: usize,
    /// Its entries.
    pub entries: usize,
    /// One for each picture.
    pub outcomes: Vec<Outcome>,
}

impl Shapes {
    /// Sums up what indexes with `classes` made of the same pictures, and the rows that could not
    /// be read.
    pub fn new(labels: String, classes: &[String], scored: &[Scored], broken: &[RowError]) -> Self {
        let mut points = Vec::new();
        let mut errors: Vec<RowReport> = Vec::new();
        for one in scored {
            for error in Report::new(classes.to_vec(), &one.outcomes, broken, false).errors {
                // What cannot be used cannot be used by any of the indexes.
                if !errors.iter().any(|known| known.line == error.line) {
                    errors.push(error);
                }
            }
            for (kind, stage) in KINDS.into_iter().flat_map(|kind| STAGES.map(|stage| (kind, stage))) {
                points.extend(Point::new(one, classes, kind, stage));
            }
        }
        let stage = |point: &Point| STAGES.iter().position(|stage| *stage == point.stage);
        let kind = |point: &Point| KINDS.iter().position(|kind| *kind == point.kind);
        points.sort_by_key(|point| (kind(point), stage(point), point.hand_shapes));
        Self { labels, classes: classes.len(), points, errors }
    }

    /// The table for a person.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{:<9}  {:<5}  {:>11}  {:>9}  {:>5}  {:>6}  {:>8}  {:>18}\n",
            "pictures", "stage", "hand shapes", "entries", "n", "top-1", "95 %", "orientation median"
        );
        for point in &self.points {
            let interval = format!("{:.0}..{:.0}", 100.0 * point.top1_low, 100.0 * point.top1_high);
            let median =
                point.orientation_median_deg.map(|median| format!("{median:.1}°")).unwrap_or_default();
            let line = format!(
                "{:<9}  {:<5}  {:>11}  {:>9}  {:>5}  {:>4.0} %  {interval:>8}  {median:>18}",
                point.kind.to_string(),
                point.stage,
                point.hand_shapes,
                point.entries,
                point.n,
                100.0 * point.top1,
            );
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{}", line.trim_end());
        }
        text.push_str(&errors_text(&self.errors));
        text
    }
}

impl Point {
    /// `None` where there is no such picture.
    fn new(scored: &Scored, classes: &[String], kind: Kind, stage: &'static str) -> Option<Self> {
        let own = scored.outcomes.iter().filter(|outcome| {
            let label = &outcome.label;
            label.kind == kind && label.stage == stage && label.grasp != OTHER
        });
        let report = Report::new(classes.to_vec(), own, &[], false);
        let [top1_low, top1_high] = report.confusion.share().interval();
        (report.n > 0).then(|| Self {
            kind,
            stage,
            hand_shapes: scored.hand_shapes,
            entries: scored.entries,
            n: report.n,
            top1: report.top1,
            top1_low,
            top1_high,
            orientation_median_deg: report.orientation_error_deg.median,
            orientation_mean_deg: report.orientation_error_deg.mean,
            index: scored.index.clone(),
        })
    }
}
