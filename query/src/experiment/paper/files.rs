//! The figures as files.

use std::path::Path;

use serde::Serialize;

use super::super::{csv_of, json_of, write_files};
use super::figures::{KindResult, Paper, SetResult};
use super::plot;
use crate::evaluate::labels::Kind;
use grasp_answer::record::UNKNOWN;

/// A line of `paper.csv`. Columns are an interface: they may be added to, never renamed.
#[derive(Serialize)]
struct Row {
    kind: Kind,
    set: &'static str,
    n: usize,
    top1: f64,
    top1_low: f64,
    top1_high: f64,
    unknown: usize,
    orientation_n: usize,
    orientation_mean_deg: Option<f64>,
    orientation_median_deg: Option<f64>,
    euler_x_deg: Option<f64>,
    euler_y_deg: Option<f64>,
    euler_z_deg: Option<f64>,
    paper_n: usize,
    paper_top1: f64,
    paper_human_top1: Option<f64>,
    paper_euler_x_deg: Option<f64>,
    paper_euler_y_deg: Option<f64>,
    paper_euler_z_deg: Option<f64>,
}

/// A cell of a matrix: a line of `confusion.csv`.
#[derive(Serialize)]
struct Cell<'a> {
    kind: Kind,
    set: &'static str,
    labelled: &'a str,
    answered: &'a str,
    count: usize,
    share: f64,
}

/// A step of the cumulative distribution: a line of `orientation.csv`.
#[derive(Serialize)]
struct Step {
    kind: Kind,
    set: &'static str,
    error_deg: f64,
    share: f64,
}

pub(super) fn write(paper: &Paper, folder: &Path) -> anyhow::Result<()> {
    let sets = || paper.kinds.iter().flat_map(|kind| kind.sets.iter().map(move |set| (kind, set)));
    let bytes = [
        csv_of(sets().map(|(kind, set)| row(kind, set)))?,
        csv_of(sets().flat_map(|(kind, set)| cells(kind, set)))?,
        csv_of(sets().flat_map(|(kind, set)| steps(kind, set)))?,
        json_of(paper)?,
        plot::confusion(paper).into_bytes(),
        plot::orientation(paper).into_bytes(),
    ];
    write_files(folder, Paper::FILES, bytes)
}

fn row(kind: &KindResult, set: &SetResult) -> Row {
    let axis = |angles: Option<[f64; 3]>, n: usize| angles.and_then(|angles| angles.get(n).copied());
    let (ours, theirs) = (set.euler_error_deg, set.paper.euler_error_deg);
    Row {
        kind: kind.kind,
        set: set.set,
        n: set.n,
        top1: set.top1,
        top1_low: set.top1_interval[0],
        top1_high: set.top1_interval[1],
        unknown: set.unknown,
        orientation_n: set.orientation_error_deg.n,
        orientation_mean_deg: set.orientation_error_deg.mean,
        orientation_median_deg: set.orientation_error_deg.median,
        euler_x_deg: axis(ours, 0),
        euler_y_deg: axis(ours, 1),
        euler_z_deg: axis(ours, 2),
        paper_n: set.paper.top1.n,
        paper_top1: set.paper.top1.top1(),
        paper_human_top1: set.paper.human_top1.map(|share| share.top1()),
        paper_euler_x_deg: axis(theirs, 0),
        paper_euler_y_deg: axis(theirs, 1),
        paper_euler_z_deg: axis(theirs, 2),
    }
}

fn cells<'a>(kind: &KindResult, set: &'a SetResult) -> Vec<Cell<'a>> {
    let (kind, set_name) = (kind.kind, set.set);
    let confusion = &set.confusion;
    let answers = || confusion.classes.iter().map(String::as_str).chain([UNKNOWN]);
    let rows = confusion.classes.iter().zip(&confusion.counts);
    rows.flat_map(|(labelled, counts)| {
        let n: usize = counts.iter().sum();
        answers().zip(counts).map(move |(answered, &count)| {
            let share = count as f64 / n.max(1) as f64;
            Cell { kind, set: set_name, labelled, answered, count, share }
        })
    })
    .collect()
}

fn steps(kind: &KindResult, set: &SetResult) -> Vec<Step> {
    let errors = &set.orientation_errors_deg;
    let share = |at: usize| (at + 1) as f64 / errors.len() as f64;
    let steps = errors.iter().enumerate();
    steps
        .map(|(at, &error_deg)| Step { kind: kind.kind, set: set.set, error_deg, share: share(at) })
        .collect()
}
