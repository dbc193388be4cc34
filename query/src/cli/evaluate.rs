//! `grasp-query evaluate`.

use std::io::{self, Write as _};
use std::path::PathBuf;

use anyhow::Context as _;
use grasp_index::AtomicFile;

use super::global::Global;
use super::index_file::IndexFile;
use super::options::RecogniseArguments;
use super::overwriting::refuse_overwriting;
use super::selection::Selection;
use super::status::{ERROR, SUCCESS};
use crate::evaluate::Outcome;
use crate::evaluate::report::{self, Report};
use grasp_recognise::orientation::xyzw;
use grasp_recognise::{Evidence, Recogniser};

const EXAMPLES: &str = "\
Examples:
  grasp-query evaluate tests/pictures/labels.csv
  grasp-query evaluate tests/pictures/labels.csv --where kind=camera --where stage=grasp
  grasp-query evaluate tests/pictures/labels.csv --json --predictions answers.csv
  grasp-query evaluate tests/pictures/labels.csv --exact  what the search costs in accuracy

LABELS.csv has the columns file, kind (segmented or camera), grasp, and where known mask, stage, hand, qx, qy, qz, qw
(camera_from_hand) and any others. Exit status: 0, or 2 where the table or a picture of it could not be used.";

/// Score labelled pictures: accuracy, confusion matrix, orientation error, segmentation.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Evaluate {
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    index: IndexFile,
    /// Take the labelled masks of camera pictures instead of finding the hands.
    #[arg(long)]
    labelled_masks: bool,
    /// Write each picture's answer as a table.
    #[arg(long, value_name = "OUT.csv")]
    predictions: Option<PathBuf>,
    /// Print the report as one JSON record.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recognise: RecogniseArguments,
}

impl Evaluate {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        if let Some(out) = &self.predictions {
            refuse_overwriting(out, [self.selection.path(), self.index.path().as_path()])?;
        }
        let index = self.index.open_for_pictures()?;
        let classes: Vec<String> = index.catalogue().classes.iter().map(|class| class.name.clone()).collect();
        let selected = self.selection.read(&classes)?;
        let recogniser = Recogniser::new(&index, self.recognise.options());
        let outcomes = selected.score(&recogniser, self.labelled_masks, global)?;
        if let Some(path) = &self.predictions {
            write_predictions(path, &outcomes).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let report = Report::new(classes, &outcomes, &selected.broken, self.recognise.hand_is_free());
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &report).map_err(io::Error::from)?;
            writeln!(out)?;
        } else {
            write!(out, "{}", report::text(&report))?;
        }
        Ok(if report.errors.is_empty() { SUCCESS } else { ERROR })
    }
}

fn write_predictions(path: &std::path::Path, outcomes: &[Outcome]) -> anyhow::Result<()> {
    let mut table = csv::Writer::from_writer(AtomicFile::create(path)?);
    let columns = [
        "file",
        "kind",
        "stage",
        "labelled",
        "grasp",
        "probability",
        "hand",
        "qx",
        "qy",
        "qz",
        "qw",
        "nearest",
        "orientation_error_deg",
        "iou_hand",
        "ms",
        "error",
        "trust",
    ];
    table.write_record(columns.into_iter().chain(Evidence::NAMES))?;
    let number = |value: Option<f64>| value.map(|value| format!("{value:.6}")).unwrap_or_default();
    for outcome in outcomes {
        let label = &outcome.label;
        let guess = outcome.result.as_ref().ok();
        let rotation = guess.map(|guess| xyzw(&guess.orientation));
        let axis = |n: usize| number(rotation.and_then(|rotation| rotation.get(n).copied()));
        let columns = [
            label.file.clone(),
            label.columns.get("kind").cloned().unwrap_or_default(),
            label.stage.clone(),
            label.grasp.clone(),
            guess.map(|guess| guess.grasp.clone()).unwrap_or_default(),
            number(guess.map(|guess| guess.probability)),
            guess.map(|guess| guess.hand.to_string()).unwrap_or_default(),
            axis(0),
            axis(1),
            axis(2),
            axis(3),
            number(guess.map(|guess| guess.nearest)),
            number(outcome.orientation_error_deg()),
            number(outcome.iou.map(|iou| iou.hand)),
            number(Some(outcome.ms)),
            outcome.result.as_ref().err().map(|miss| miss.message.clone()).unwrap_or_default(),
            number(guess.and_then(|guess| guess.trust)),
        ];
        let measures = guess.map(|guess| guess.evidence.measures()).unwrap_or_default().map(number);
        table.write_record(columns.into_iter().chain(measures))?;
    }
    table.into_inner().map_err(|error| error.into_error())?.commit()?;
    Ok(())
}
