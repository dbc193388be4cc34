//! `grasp-query experiment paper`.

use std::path::PathBuf;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::outputs::make_folder;
use crate::experiment::paper::{Class, Paper};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};

/// The paper's Section VII: accuracy, confusion and orientation on X, X' and X'', beside what it
/// reports.
///
/// X is every selected picture, X' those of the stages close and grasp, X'' those of the stage
/// grasp. Segmented and camera pictures are reported separately. With --out, DIR gets paper.csv,
/// confusion.csv, orientation.csv, paper.json, confusion.svg (Figure 7) and orientation.svg (Figure
/// 8).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment paper tests/pictures/labels.csv
  grasp-query experiment paper tests/pictures/labels.csv --hand right --out results
  grasp-query experiment paper tests/pictures/labels.csv --part final --where kind=segmented --json

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
pub(super) struct PaperArguments {
    #[command(flatten)]
    index: IndexFile,
    /// Write tables and drawings into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl PaperArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes = index.catalogue().classes.iter();
        let classes: Vec<Class> =
            classes.map(|class| Class { grasp: class.name.clone(), cutkosky: class.cutkosky }).collect();
        let selected = self.labelled.read(&index)?;
        if let Some(folder) = &self.out {
            make_folder(
                folder,
                &Paper::FILES,
                [self.labelled.selection.path(), self.index.path().as_path()],
            )?;
        }
        let outcomes = self.labelled.score(&selected, &index, self.labelled.recognise.options()?, global)?;
        let path = self.index.path().display().to_string();
        let paper = Paper::new(self.labelled.table(), path, classes, &outcomes, &selected.broken);
        if let Some(folder) = &self.out {
            paper.write(folder)?;
        }
        print(self.labelled.json, &paper, || paper.text())?;
        Ok(if paper.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
