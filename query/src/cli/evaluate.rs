//! `grasp-query evaluate`.

use std::path::PathBuf;

use anyhow::Context as _;
use grasp_index::AtomicFile;

use super::figures::print;
use super::index_file::IndexFile;
use super::labelled::LabelledArguments;
use super::outputs::check_file;
use crate::evaluate::Outcome;
use crate::evaluate::report::{self, Report};
use grasp_program::status::{ERROR, SUCCESS};
use grasp_program::{Global, output_file};
use grasp_recognise::Evidence;
use grasp_recognise::orientation::xyzw;

const EXAMPLES: &str = "\
Examples:
  grasp-query evaluate tests/pictures/labels.csv
  grasp-query evaluate tests/pictures/labels.csv --where kind=camera --where stage=grasp
  grasp-query evaluate tests/pictures/labels.csv --json --predictions predictions.csv
  grasp-query evaluate tests/pictures/labels.csv --exact  what the search costs in accuracy

LABELS.csv has the columns file, kind (segmented or camera), grasp, and where known mask, stage,
hand, qx, qy, qz, qw (camera_from_hand) and any others.

Exit status: 0, or 2 where the table or a picture of it could not be used.";

/// Score labelled pictures: accuracy, confusion matrix, orientation error, segmentation.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Evaluate {
    #[command(flatten)]
    index: IndexFile,
    /// Write each picture's answer as a table.
    #[arg(long, value_name = "OUT.csv", value_parser = output_file())]
    predictions: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl Evaluate {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let selected = self.labelled.read(&index)?;
        if let Some(out) = &self.predictions {
            let read = [self.labelled.selection.path().to_owned(), self.index.path()];
            check_file(out, read.iter().chain(&selected.files()).map(PathBuf::as_path))?;
        }
        let recognise = &self.labelled.recognise;
        let outcomes = self.labelled.score(&selected, &index, recognise.options()?, global)?;
        if let Some(path) = &self.predictions {
            write_predictions(path, &outcomes).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let classes = index.catalogue().class_names();
        let report = Report::new(classes, &outcomes, &selected.broken, recognise.hand_is_free());
        print(self.labelled.json, &report, || report::text(&report))?;
        Ok(if report.errors.is_empty() { SUCCESS } else { ERROR })
    }
}

fn write_predictions(path: &std::path::Path, outcomes: &[Outcome]) -> anyhow::Result<()> {
    let mut table = csv::Writer::from_writer(AtomicFile::create(path)?);
    let number = |value: Option<f64>| value.map(|value| format!("{value:.6}")).unwrap_or_default();
    for (at, outcome) in outcomes.iter().enumerate() {
        let label = &outcome.label;
        let guess = outcome.result.as_ref().ok();
        let rotation = guess.map(|guess| xyzw(&guess.orientation));
        let axis = |n: usize| number(rotation.and_then(|rotation| rotation.get(n).copied()));
        let fields = [
            ("file", label.file.clone()),
            ("kind", label.columns.get("kind").cloned().unwrap_or_default()),
            ("stage", label.stage.clone()),
            ("labelled", label.grasp.clone()),
            ("grasp", guess.map(|guess| guess.grasp.clone()).unwrap_or_default()),
            ("probability", number(guess.map(|guess| guess.probability))),
            ("hand", guess.map(|guess| guess.hand.to_string()).unwrap_or_default()),
            ("qx", axis(0)),
            ("qy", axis(1)),
            ("qz", axis(2)),
            ("qw", axis(3)),
            ("distance", number(guess.map(|guess| guess.nearest))),
            ("orientation_error_deg", number(outcome.orientation_error_deg())),
            ("iou_hand", number(outcome.iou.map(|iou| iou.hand))),
            ("ms", number(Some(outcome.ms))),
            ("error", outcome.result.as_ref().err().map(|miss| miss.message.clone()).unwrap_or_default()),
            ("trust", number(guess.and_then(|guess| guess.trust))),
        ];
        if at == 0 {
            let columns = fields.each_ref().map(|(column, _)| *column);
            table.write_record(columns.into_iter().chain(Evidence::NAMES))?;
        }
        let measures = guess.map(|guess| guess.evidence.measures()).unwrap_or_default().map(number);
        table.write_record(fields.map(|(_, value)| value).into_iter().chain(measures))?;
    }
    table.into_inner().map_err(|error| error.into_error())?.commit()?;
    Ok(())
}
