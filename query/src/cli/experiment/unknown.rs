//! `grasp-query experiment unknown`.

use std::path::PathBuf;

use anyhow::bail;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::outputs::make_folder;
use crate::cli::selection::Selected;
use crate::evaluate::Outcome;
use crate::evaluate::labels::OTHER;
use crate::evaluate::report::RowReport;
use crate::experiment::unknown::{Limits, Unknown};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::{Accept, RecogniseOptions, Trust};

/// How well known hands are distinguished from others, by the distance of the nearest entry, by the
/// probability, by the trust in the mask, and by the probability that an answer states, which that
/// trust has tempered.
///
/// Known are the pictures labelled with a class of the index, others those labelled `other` and
/// those of --others. With --out, DIR gets unknown.csv, unknown.json and unknown.svg: the share of
/// known hands kept over that of others, at every limit.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment unknown tests/pictures/labels.csv --others OTHERS.csv
  grasp-query experiment unknown tests/pictures/labels.csv --others OTHERS.csv --hand right \\
    --out results

LABELS.csv and OTHERS.csv are as for `grasp-query evaluate`; of OTHERS.csv every row counts,
and its labels do not.

Exit status: 0, or 2 where a table or a picture of it could not be used.")]
pub(super) struct UnknownArguments {
    #[command(flatten)]
    index: IndexFile,
    /// A table of pictures that show none of the grasps, whatever they are labelled.
    #[arg(long, value_name = "OTHERS.csv")]
    others: Option<PathBuf>,
    /// Write table and drawing into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl UnknownArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let selected = self.labelled.read(&index)?;
        let others = self.others.as_ref().map(|path| Selected::others(path)).transpose()?;
        if others.is_none() && !selected.labels.iter().any(|label| label.grasp == OTHER) {
            bail!(
                "there is nothing to distinguish the grasps from: label pictures of other hands `{OTHER}`, or name a table of such by --others"
            );
        }
        if let Some(folder) = &self.out {
            let tables = self.others.iter().map(PathBuf::as_path).chain([self.labelled.selection.path()]);
            make_folder(folder, &Unknown::FILES, tables.chain([self.index.path().as_path()]))?;
        }
        let score = |options: &RecogniseOptions| -> anyhow::Result<Vec<Outcome>> {
            let mut outcomes = self.labelled.score(&selected, &index, options.clone(), global)?;
            if let Some(others) = &others {
                outcomes.extend(self.labelled.score(others, &index, options.clone(), global)?);
            }
            Ok(outcomes)
        };
        let options = self.labelled.recognise.options()?;
        let trust = Trust::of_descriptor(&index.catalogue().descriptor, &options.segment.by);
        let limits = Limits::new(options.accept, &index.catalogue().calibration, trust.least);
        // What is measured must not have been decided before; what the limits make of it, by all
        // that the program goes by.
        let measured = score(&RecogniseOptions { accept: Accept::Always, temper: false, ..options.clone() })?;
        let stated = score(&options)?;
        let mut unknown = Unknown::new(self.labelled.table(), &measured, &selected.broken, &stated, limits);
        if let (Some(path), Some(others)) = (&self.others, &others) {
            unknown.errors.extend(RowReport::of_table(path, &others.broken));
        }
        if let Some(folder) = &self.out {
            unknown.write(folder)?;
        }
        print(self.labelled.json, &unknown, || unknown.text())?;
        Ok(if unknown.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
