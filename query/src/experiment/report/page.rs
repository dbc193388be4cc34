//! The page: what the template is filled with.

use std::path::Path;

use askama::Template;
use grasp_terminal::text::counted;
use rayon::prelude::*;

use super::super::write_file;
use super::accuracy::Accuracy;
use super::findings::{Findings, Speed, percents};
use super::shelf::{Shelf, Shown};
use super::{plot, thumbnail};
use crate::evaluate::errors::Errors;
use crate::evaluate::report::{Report, RowReport};
use grasp_answer::record::UNKNOWN;

/// All that the template says in more than a word.
#[derive(Template)]
#[template(path = "report.html")]
struct Page<'a> {
    labels: &'a str,
    index: &'a str,
    version: &'static str,
    report: &'a Report,
    /// The accuracy over all pictures.
    all: Option<Row<'a>>,
    groups: Vec<Group<'a>>,
    confusion: Vec<Line<'a>>,
    drawing: String,
    rotation: Option<Rotation>,
    speed: Speed,
    shelves: Vec<Cards<'a>>,
}

/// Accuracy by one column.
struct Group<'a> {
    by: &'static str,
    rows: Vec<Row<'a>>,
}

struct Row<'a> {
    name: &'a str,
    share: String,
    interval: String,
    n: usize,
    /// Percent: the interval's ends and the share.
    bar: [f64; 3],
}

/// A row of the confusion matrix.
struct Line<'a> {
    class: &'a str,
    cells: Vec<Cell>,
}

struct Cell {
    count: usize,
    /// Of the row's pictures, in whole percent.
    percent: usize,
    is_right: bool,
}

/// What is said of rotations where some are labelled.
struct Rotation {
    all: String,
    right_class: String,
}

struct Cards<'a> {
    title: &'static str,
    about: &'static str,
    class: &'static str,
    /// How many pictures there are of this sort, and how many are shown.
    counts: String,
    cards: Vec<Card<'a>>,
}

struct Card<'a> {
    shown: &'a Shown,
    /// A `data:` address, or why there is none.
    picture: anyhow::Result<String>,
    answer: String,
}

impl Findings {
    /// Writes the page; pictures are read from `folder`, which the table's paths are relative to.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, folder: &Path, out: &Path) -> anyhow::Result<()> {
        write_file(out, html(self, folder)?.as_bytes())
    }
}

/// The page as HTML; pictures are read from `folder`. A picture that has gone since it was
/// recognised is said to be missing.
fn html(findings: &Findings, folder: &Path) -> anyhow::Result<String> {
    let report = &findings.report;
    let (all, grouped): (Vec<_>, Vec<_>) =
        findings.accuracy.iter().partition(|accuracy| accuracy.by == "all");
    let mut groups: Vec<Group<'_>> = Vec::new();
    for accuracy in grouped {
        match groups.last_mut() {
            Some(group) if group.by == accuracy.by => group.rows.push(Row::new(accuracy)),
            _ => groups.push(Group { by: accuracy.by, rows: vec![Row::new(accuracy)] }),
        }
    }
    let shown = &findings.shown;
    let shelves = [
        ("Sure and right", "right", "the most probable first", &shown.right),
        (
            "Sure and wrong",
            "wrong",
            "the most probable first: a wrong label, or what the index has not seen",
            &shown.wrong,
        ),
        (
            "Doubtful",
            "doubtful",
            "no hand, an unknown grasp, or a probability below 0.5; the least probable first",
            &shown.doubtful,
        ),
    ];
    let shelves = shelves.map(|(title, class, about, shelf)| Cards::new(title, class, about, shelf, folder));
    let page = Page {
        labels: &findings.labels,
        index: &findings.index,
        version: env!("CARGO_PKG_VERSION"),
        report,
        all: all.first().map(|accuracy| Row::new(accuracy)),
        groups,
        confusion: lines(report),
        drawing: plot::svg(findings),
        rotation: Rotation::new(report),
        speed: findings.speed,
        shelves: shelves.into(),
    };
    Ok(page.render()?)
}

impl<'a> Row<'a> {
    fn new(accuracy: &'a Accuracy) -> Self {
        let (share, interval) = percents(accuracy.share);
        let [low, high] = accuracy.interval;
        let bar = [low, high, accuracy.share.top1()].map(|share| (1e3 * share).round() / 10.0);
        Self { name: &accuracy.name, share, interval, n: accuracy.share.n, bar }
    }
}

fn lines(report: &Report) -> Vec<Line<'_>> {
    let rows = report.confusion.classes.iter().zip(&report.confusion.counts).enumerate();
    rows.map(|(row, (class, counts))| {
        let n = counts.iter().sum::<usize>().max(1);
        let cells = counts.iter().enumerate().map(|(column, &count)| {
            let percent = (100 * count + n / 2) / n;
            Cell { count, percent, is_right: row == column }
        });
        Line { class, cells: cells.collect() }
    })
    .collect()
}

impl Rotation {
    fn new(report: &Report) -> Option<Self> {
        let said = |errors: &Errors| {
            let (mean, median) = (errors.mean?, errors.median?);
            let pictures = counted(errors.n, ["picture", "pictures"]);
            Some(format!("median {median:.1}°, mean {mean:.1}°, of {pictures}"))
        };
        let all = said(&report.orientation_error_deg)?;
        let right_class = said(&report.orientation_error_deg_right_class).unwrap_or_else(|| "none".into());
        Some(Self { all, right_class })
    }
}

impl<'a> Cards<'a> {
    fn new(
        title: &'static str,
        class: &'static str,
        about: &'static str,
        shelf: &'a Shelf,
        folder: &Path,
    ) -> Self {
        let counts = match shelf.n - shelf.pictures.len() {
            0 => counted(shelf.n, ["picture", "pictures"]),
            _ => format!("{} of {}", shelf.pictures.len(), counted(shelf.n, ["picture", "pictures"])),
        };
        let cards = shelf.pictures.par_iter().map(|shown| Card::new(shown, folder)).collect();
        Self { title, about, class, counts, cards }
    }
}

impl<'a> Card<'a> {
    fn new(shown: &'a Shown, folder: &Path) -> Self {
        let picture = thumbnail::address(&folder.join(&shown.file));
        let stated = shown.probability.unwrap_or_default();
        let answer = match (&shown.grasp, &shown.most_probable) {
            (None, _) => "no hand found".to_owned(),
            (Some(grasp), Some(most)) if grasp == UNKNOWN => format!("{UNKNOWN}; {most} {stated:.2}"),
            (Some(grasp), _) => format!("{grasp} {stated:.2}"),
        };
        Self { shown, picture, answer }
    }
}

/// What an unreadable row is called.
fn file_of(row: &RowReport) -> &str {
    row.file.as_deref().unwrap_or("the table")
}
