//! `grasp-query evaluate`.

use std::io::{self, Write as _};
use std::path::PathBuf;

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use super::Global;
use super::index_file::IndexFile;
use super::options::RecogniseArguments;
use crate::evaluate::labels::{self, OTHER, Part, RowError};
use crate::evaluate::report::{self, Report};
use crate::evaluate::{Outcome, folder_of, score};
use crate::output::record::xyzw;
use crate::recognise::Recogniser;

const EXAMPLES: &str = "\
Examples:
  grasp-query evaluate labels.csv
  grasp-query evaluate labels.csv --where kind=camera --where stage=grasp --part choose
  grasp-query evaluate labels.csv --json --predictions answers.csv
  grasp-query evaluate labels.csv --exact                what the search costs in accuracy

LABELS.csv has the columns file, kind (segmented or camera), grasp, and where known mask, stage, hand, qx, qy, qz, qw
(camera_from_hand) and any others. Exit status: 0, or 2 where the table or a picture of it could not be used.";

/// Score labelled pictures: accuracy, confusion matrix, orientation error, segmentation.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Evaluate {
    /// The table of labelled pictures.
    #[arg(value_name = "LABELS.csv")]
    labels: PathBuf,
    #[command(flatten)]
    index: IndexFile,
    /// Score only rows whose column has this value; several must all hold.
    #[arg(long = "where", value_name = "COLUMN=VALUE", value_parser = parse_condition)]
    conditions: Vec<(String, String)>,
    /// Score all pictures, the seven tenths to choose parameters by, or the rest (split by a hash of the file's name).
    #[arg(long, value_enum, default_value_t = Part::All)]
    part: Part,
    /// Take the labelled masks of camera pictures instead of segmenting by colour.
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
            super::refuse_overwriting(out, [self.labels.as_path(), self.index.path().as_path()])?;
        }
        let index = self.index.open_for_pictures()?;
        let classes: Vec<String> = index.catalogue().classes.iter().map(|class| class.name.clone()).collect();
        let mut broken = Vec::new();
        let mut selected = Vec::new();
        for row in labels::read(&self.labels)? {
            match row {
                Ok(label) if !label.is_selected(self.part, &self.conditions) => {}
                Ok(label) if label.grasp == OTHER || classes.contains(&label.grasp) => selected.push(label),
                Ok(label) => broken.push(RowError {
                    line: label.line,
                    message: format!(
                        "`{}` is no class of the index: it has {}, and `{OTHER}` is for none of them",
                        label.grasp,
                        classes.join(", ")
                    ),
                }),
                Err(error) => broken.push(error),
            }
        }
        let Some(first) = selected.first() else {
            let name = self.labels.display();
            match broken.first() {
                Some(error) => bail!("no row of {name} can be used; line {}: {}", error.line, error.message),
                None => bail!("no row of {name} is selected: check --where and --part"),
            }
        };
        let folder = folder_of(&self.labels, &first.file);
        let recogniser = Recogniser::new(&index, self.recognise.options());
        let bar = progress_bar(selected.len() as u64, !global.no_progress);
        let outcomes: Vec<Outcome> = selected
            .into_par_iter()
            .map(|label| {
                let outcome = score(&recogniser, &folder, label, self.labelled_masks);
                bar.inc(1);
                outcome
            })
            .collect();
        bar.finish_and_clear();

        if let Some(path) = &self.predictions {
            write_predictions(path, &outcomes).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let report = Report::new(classes, &outcomes, &broken, self.recognise.hand_is_free());
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &report).map_err(io::Error::from)?;
            writeln!(out)?;
        } else {
            write!(out, "{}", report::text(&report))?;
        }
        Ok(if report.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}

fn parse_condition(text: &str) -> Result<(String, String), String> {
    let (column, value) = text.split_once('=').ok_or("COLUMN=VALUE is needed, for example stage=grasp")?;
    Ok((column.to_owned(), value.to_owned()))
}

/// A bar on a terminal's standard error, and none elsewhere.
fn progress_bar(length: u64, wanted: bool) -> ProgressBar {
    let target = if wanted { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    match ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

fn write_predictions(path: &std::path::Path, outcomes: &[Outcome]) -> anyhow::Result<()> {
    let mut table = csv::Writer::from_writer(AtomicFile::create(path)?);
    table.write_record([
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
    ])?;
    let number = |value: Option<f64>| value.map(|value| format!("{value:.6}")).unwrap_or_default();
    for outcome in outcomes {
        let label = &outcome.label;
        let guess = outcome.result.as_ref().ok();
        let rotation = guess.map(|guess| xyzw(&guess.orientation));
        let axis = |n: usize| number(rotation.and_then(|rotation| rotation.get(n).copied()));
        table.write_record([
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
        ])?;
    }
    table.into_inner().map_err(|error| error.into_error())?.commit()?;
    Ok(())
}
