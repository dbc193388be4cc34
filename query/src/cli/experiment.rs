//! `grasp-query experiment`.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Subcommand;

use super::Global;
use super::index_file::IndexFile;
use super::options::RecogniseArguments;
use super::selection::Selection;
use crate::experiment::paper::{Class, Paper};
use crate::recognise::Recogniser;

/// Repeat an experiment over labelled pictures, as tables and drawings.
#[derive(Debug, clap::Args)]
pub(super) struct Experiment {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    Paper(PaperArguments),
}

/// The paper's Section VII: accuracy, confusion and orientation on X, X' and X'', beside what it reports.
///
/// X is every selected picture, X' those of the stages close and grasp, X'' those of the stage grasp. Segmented and camera
/// pictures are told apart. With --out, DIR gets paper.csv, confusion.csv, orientation.csv, paper.json, confusion.svg
/// (Figure 7) and orientation.svg (Figure 8).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment paper labels.csv
  grasp-query experiment paper labels.csv --hand right --out results
  grasp-query experiment paper labels.csv --part final --where kind=segmented --json

LABELS.csv is as for `grasp-query evaluate`. Exit status: 0, or 2 where the table or a picture of it could not be used.")]
struct PaperArguments {
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    index: IndexFile,
    /// Write tables and drawings into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Take the labelled masks of camera pictures instead of segmenting by colour.
    #[arg(long)]
    labelled_masks: bool,
    /// Print the figures as one JSON record.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recognise: RecogniseArguments,
}

impl Experiment {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        match &self.name {
            Name::Paper(paper) => paper.run(global),
        }
    }
}

impl PaperArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes = index.catalogue().classes.iter();
        let classes: Vec<Class> =
            classes.map(|class| Class { grasp: class.name.clone(), cutkosky: class.cutkosky }).collect();
        let names: Vec<String> = classes.iter().map(|class| class.grasp.clone()).collect();
        let selected = self.selection.read(&names)?;
        let recogniser = Recogniser::new(&index, self.recognise.options());
        let outcomes = selected.score(&recogniser, self.labelled_masks, global);
        let (labels, path) = (self.selection.path().display(), self.index.path());
        let paper =
            Paper::new(labels.to_string(), path.display().to_string(), classes, &outcomes, &selected.broken);
        if let Some(folder) = &self.out {
            paper.write(folder)?;
        }
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &paper).map_err(io::Error::from)?;
            writeln!(out)?;
        } else {
            write!(out, "{}", paper.text())?;
        }
        Ok(if paper.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}
