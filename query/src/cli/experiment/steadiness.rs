//! `grasp-query experiment steadiness`.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use rayon::prelude::*;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::labelled::LabelledArguments;
use crate::cli::outputs::make_folder;
use crate::evaluate::labels::Label;
use crate::experiment::steadiness::{Recognisers, Steadiness};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::HandChoice;

/// How steady answers are: every picture as it is, and changed so little that a person would answer
/// the same.
///
/// A picture is mirrored, turned by 8 degrees, made darker, brighter, warmer, colder, paler, a
/// little blurred or larger, or cut by a twentieth at one side; labelled masks are changed with
/// their pictures. The mean over all variants is less a matter of luck than the pictures as they
/// are: compare indexes, networks and options by it where pictures are few. With --out, DIR gets
/// steadiness.csv (a line a picture and variant) and steadiness.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment steadiness tests/pictures/labels.csv
  grasp-query experiment steadiness LABELS.csv --where kind=camera --accept always --out results

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
pub(super) struct SteadinessArguments {
    #[command(flatten)]
    index: IndexFile,
    /// Write tables into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl SteadinessArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let selected = self.labelled.read(&index)?;
        let meant: Vec<&Label> = selected.labels.iter().filter(|label| Steadiness::is_meant(label)).collect();
        if meant.is_empty() {
            bail!("no picture of {} shows one of the index's grasps", self.labelled.table());
        }
        if let Some(folder) = &self.out {
            make_folder(
                folder,
                &Steadiness::FILES,
                [self.labelled.selection.path(), self.index.path().as_path()],
            )?;
        }
        self.labelled.check_masks(&selected);
        let options = self.labelled.recognise.options()?;
        let hand_is_given = options.hand != HandChoice::Auto;
        let recognisers = Recognisers::new(&index, options, self.labelled.labelled_masks);
        let bar = global.progress().bar(meant.len() as u64, "recognising", "pictures");
        let found = meant.into_par_iter().map(|label| {
            let answers = recognisers.answers(&selected.folder, label);
            bar.inc(1);
            (label, answers)
        });
        let found = found.collect();
        drop(bar);
        index.check_unchanged().context("cannot use the index")?;
        let steadiness = Steadiness::new(self.labelled.table(), found, &selected.broken, hand_is_given);
        if let Some(folder) = &self.out {
            steadiness.write(folder)?;
        }
        print(self.labelled.json, &steadiness, || steadiness.text())?;
        Ok(if steadiness.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
