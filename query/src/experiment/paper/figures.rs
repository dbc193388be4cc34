//! The figures, summed up from outcomes.

use serde::Serialize;

use super::published::Published;
use crate::evaluate::Outcome;
use crate::evaluate::confusion::Confusion;
use crate::evaluate::errors::Errors;
use crate::evaluate::labels::{Kind, OTHER, RowError};
use crate::evaluate::report::{Report, RowReport};
use crate::experiment::KINDS;

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Paper {
    /// The table of labels.
    pub labels: String,
    /// The index.
    pub index: String,
    /// The index's classes.
    pub classes: Vec<Class>,
    /// The kinds of pictures that there are, each with its three sets.
    pub kinds: Vec<KindResult>,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

/// A class of the index.
#[derive(Clone, Debug, Serialize)]
pub struct Class {
    /// Its name.
    pub grasp: String,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
}

/// The sets of one kind of pictures.
#[derive(Clone, Debug, Serialize)]
pub struct KindResult {
    /// Segmented or camera pictures.
    pub kind: Kind,
    /// X, X' and X''.
    pub sets: Vec<SetResult>,
}

/// One of the paper's three sets.
#[derive(Clone, Debug, Serialize)]
pub struct SetResult {
    /// `X`, `X'` or `X''`.
    pub set: &'static str,
    /// What it holds.
    pub what: &'static str,
    /// The stages of its pictures; `null` where any will do, a picture without a stage too.
    pub stages: Option<&'static [&'static str]>,
    /// Pictures.
    pub n: usize,
    /// The share of them that was classed rightly, 0..=1; one without an answer counts as wrong.
    pub top1: f64,
    /// Where the true share lies, with 95 % confidence.
    pub top1_interval: [f64; 2],
    /// Pictures in which no hand was found, or whose class is unknown.
    pub unknown: usize,
    /// Figure 7: which class was taken for which.
    pub confusion: Confusion,
    /// Figure 8: the angle between labelled and answered rotation, in degrees.
    pub orientation_error_deg: Errors,
    /// Each picture's, smallest first: the cumulative distribution.
    pub orientation_errors_deg: Vec<f64>,
    /// Figure 8 as it is drawn: the mean absolute difference of each Euler angle (about x, y, z),
    /// in degrees.
    pub euler_error_deg: Option<[f64; 3]>,
    /// What the paper has for its own set of this name.
    pub paper: Published,
}

struct Set {
    name: &'static str,
    what: &'static str,
    stages: Option<&'static [&'static str]>,
}

const SETS: [Set; 3] = [
    Set { name: "X", what: "all pictures", stages: None },
    Set { name: "X'", what: "the hand near the object", stages: Some(&["close", "grasp"]) },
    Set { name: "X''", what: "the hand grasping", stages: Some(&["grasp"]) },
];

impl Paper {
    /// Sums up outcomes over an index with `classes`, and the rows that could not be read.
    pub fn new(
        labels: String,
        index: String,
        classes: Vec<Class>,
        outcomes: &[Outcome],
        broken: &[RowError],
    ) -> Self {
        let names: Vec<String> = classes.iter().map(|class| class.grasp.clone()).collect();
        let errors = Report::new(names.clone(), outcomes, broken, false).errors;
        let kinds = KINDS.into_iter().filter_map(|kind| {
            let own: Vec<&Outcome> = outcomes
                .iter()
                .filter(|outcome| outcome.label.kind == kind && outcome.label.grasp != OTHER)
                .collect();
            let sets = || SETS.iter().map(|set| SetResult::new(set, &names, &own)).collect();
            (!own.is_empty()).then(|| KindResult { kind, sets: sets() })
        });
        Self { labels, index, kinds: kinds.collect(), classes, errors }
    }
}

impl SetResult {
    fn new(set: &Set, classes: &[String], outcomes: &[&Outcome]) -> Self {
        let holds = |outcome: &&Outcome| {
            set.stages.is_none_or(|stages| stages.contains(&outcome.label.stage.as_str()))
        };
        let own: Vec<&Outcome> = outcomes.iter().copied().filter(holds).collect();
        let report = Report::new(classes.to_vec(), own.iter().copied(), &[], false);
        let mut errors: Vec<f64> = own.iter().filter_map(|outcome| outcome.orientation_error_deg()).collect();
        errors.sort_by(f64::total_cmp);
        Self {
            set: set.name,
            what: set.what,
            stages: set.stages,
            n: report.n,
            top1: report.top1,
            top1_interval: report.confusion.share().interval(),
            unknown: report.unknown,
            confusion: report.confusion,
            orientation_error_deg: report.orientation_error_deg,
            orientation_errors_deg: errors,
            euler_error_deg: report.euler_error_deg,
            paper: Published::of(set.name),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evaluate::labels::Label;
    use crate::evaluate::{Guess, Miss};
    use grasp_recognise::{Evidence, Side};
    use nalgebra::{UnitQuaternion, Vector3};

    fn outcome(kind: Kind, stage: &str, grasp: &str, answer: Option<(&str, f64)>) -> Outcome {
        let label = Label {
            line: 2,
            file: "a.png".into(),
            mask: None,
            kind,
            grasp: grasp.into(),
            stage: stage.into(),
            hand: None,
            orientation: Some(UnitQuaternion::identity()),
            columns: [].into(),
        };
        let guess = |(grasp, degrees): (&str, f64)| Guess {
            stages: None,
            classes: vec![(grasp.to_owned(), 1.0)],
            grasp: grasp.into(),
            spread_deg: 10.0,
            probability: 0.5,
            hand: Side::Right,
            orientation: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), degrees.to_radians()),
            nearest: 0.1,
            evidence: Evidence::default(),
            trust: None,
        };
        let result = answer.map(guess).ok_or(Miss { is_rejection: true, message: "no hand".into() });
        Outcome { label, result, ms: 1.0, iou: None }
    }

    fn class(grasp: &str, cutkosky: u8) -> Class {
        Class { grasp: grasp.into(), cutkosky }
    }

    pub(in crate::experiment) fn some() -> Paper {
        let both = [Kind::Segmented, Kind::Camera];
        let outcomes: Vec<Outcome> = both
            .into_iter()
            .flat_map(|kind| {
                [
                    outcome(kind, "reach", "pinch", None),
                    outcome(kind, "reach", "precision-disc", Some(("pinch", 80.0))),
                    outcome(kind, "close", "pinch", Some(("pinch", 30.0))),
                    outcome(kind, "close", "pinch", Some(("precision-disc", 20.0))),
                    outcome(kind, "grasp", "pinch", Some(("pinch", 10.0))),
                    outcome(kind, "grasp", "other", Some(("pinch", 170.0))),
                    outcome(kind, "", "pinch", Some(("pinch", 40.0))),
                ]
            })
            .collect();
        let classes = vec![class("pinch", 9), class("precision-disc", 12)];
        Paper::new("labels.csv".into(), "grasp.idx".into(), classes, &outcomes, &[])
    }

    #[test]
    fn sets_shrink_with_the_stage_and_kinds_stay_apart() {
        let paper = some();
        assert_eq!(paper.kinds.len(), 2);
        for kind in &paper.kinds {
            let figures: Vec<(usize, f64)> = kind.sets.iter().map(|set| (set.n, set.top1)).collect();
            assert_eq!(figures, [(6, 0.5), (3, 2.0 / 3.0), (1, 1.0)]);
            let [all, near, grasping] = &kind.sets[..] else { panic!("three sets") };
            assert_eq!(all.unknown, 1);
            assert_eq!(near.confusion.counts, [[2, 1, 0], [0, 0, 0]]);
            let rounded: Vec<f64> = all.orientation_errors_deg.iter().map(|angle| angle.round()).collect();
            assert_eq!(rounded, [10.0, 20.0, 30.0, 40.0, 80.0]);
            assert!((grasping.orientation_error_deg.mean.unwrap() - 10.0).abs() < 1e-6);
            assert!((grasping.euler_error_deg.unwrap()[2] - 10.0).abs() < 1e-6);
        }
    }
}
