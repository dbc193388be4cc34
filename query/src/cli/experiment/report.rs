//! `grasp-query experiment report`.

use std::path::PathBuf;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::outputs::check_file;
use crate::experiment::report::{Findings, Source};
use grasp_program::status::{ERROR, SUCCESS};
use grasp_program::{Global, output_file};

/// Report on your own labelled pictures, as one self-contained page to read, print and pass on.
///
/// The page has the accuracy with its intervals (in all, by grasp, stage and group), the confusion
/// matrix, drawings of how probabilities come true and how far rotations are off, the speed, and
/// the pictures that tell most: the surest answers that are right, the surest that are wrong, and
/// the doubtful ones. It holds all of it in one file: it needs neither network nor scripts. The
/// pictures lie in it, made small: pass it on only where they may be.
///
/// The record of --json is that of `evaluate`, with intervals, speed and the pictures that are
/// shown.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment report tests/pictures/labels.csv --out report.html
  grasp-query experiment report tests/pictures/labels.csv --where kind=camera --show 4 \\
    --out report.html --json

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used; the page is written all
the same where some could.")]
pub(super) struct ReportArguments {
    #[command(flatten)]
    index: IndexFile,
    /// Write the page here.
    #[arg(long, value_name = "REPORT.html", value_parser = output_file())]
    out: PathBuf,
    /// Show this many pictures of each sort: surely right, surely wrong, doubtful.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(0..=1000))]
    show: u16,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl ReportArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let selected = self.labelled.read(&index)?;
        let read = [self.labelled.selection.path().to_owned(), self.index.path()];
        check_file(&self.out, read.iter().chain(&selected.files()).map(PathBuf::as_path))?;
        let recognise = &self.labelled.recognise;
        let outcomes = self.labelled.score(&selected, &index, recognise.options()?, global)?;
        let source = Source {
            labels: self.labelled.table(),
            index: self.index.path().display().to_string(),
            classes: index.catalogue().class_names(),
            hand_is_free: recognise.hand_is_free(),
        };
        let findings = Findings::new(source, &outcomes, &selected.broken, self.show.into());
        findings.write(&selected.folder, &self.out)?;
        print(self.labelled.json, &findings, || findings.text())?;
        Ok(if findings.report.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
