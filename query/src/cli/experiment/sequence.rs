//! `grasp-query experiment sequence`.

use std::path::PathBuf;

use anyhow::bail;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::options::FrameArguments;
use crate::cli::outputs::make_folder;
use crate::experiment::sequence::{self, Sequences};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::{Accept, RecogniseOptions};

/// What the frames before are worth: views of a grasp at the stages reach, close and grasp,
/// recognised one by one and in this order.
///
/// A sequence is a view (azimuth, elevation, roll) of a grasp of which all three stages are
/// labelled. With --out, DIR gets sequence.csv and sequence.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment sequence LABELS.csv --hand right
  grasp-query experiment sequence LABELS.csv --hand right --switch 0.4 --json

LABELS.csv is as for `grasp-query evaluate`, with the columns stage, azimuth, elevation and roll.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
pub(super) struct SequenceArguments {
    #[command(flatten)]
    index: IndexFile,
    /// Write the table into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
    #[command(flatten)]
    frames: FrameArguments,
}

impl SequenceArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        if self.labelled.selection.is_of_a_part() {
            bail!("--part would divide the pictures of a sequence: leave it out");
        }
        let selected = self.labelled.read(&index)?;
        sequence::check(&selected.labels)?;
        if let Some(folder) = &self.out {
            make_folder(
                folder,
                &Sequences::FILES,
                [self.labelled.selection.path(), self.index.path().as_path()],
            )?;
        }
        // A frame that is unknown by itself may count for something with the others.
        let options = RecogniseOptions { accept: Accept::Always, ..self.labelled.recognise.options()? };
        let outcomes = self.labelled.score(&selected, &index, options, global)?;
        let sequences =
            Sequences::new(self.labelled.table(), &outcomes, &selected.broken, self.frames.params());
        if let Some(folder) = &self.out {
            sequences.write(folder)?;
        }
        print(self.labelled.json, &sequences, || sequences.text())?;
        Ok(if sequences.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
