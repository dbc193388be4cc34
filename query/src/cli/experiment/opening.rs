//! `grasp-query experiment opening`.

use std::path::PathBuf;

use anyhow::bail;
use tracing::error;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::outputs::check_file;
use crate::cli::selection::{Selected, Selection, without_folders};
use crate::evaluate::Outcome;
use crate::evaluate::labels::{Kind, Label};
use crate::experiment::opening::{Fitted, Sample};
use grasp_index::Index;
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::scene::Opening;
use grasp_recognise::{Accept, HandChoice, RecogniseOptions, Recogniser, Side};

/// What hands look like before they hold something: fits how much likelier each grasp is, while
/// nothing is held yet, than it looks (query/recognise/data/opening.toml).
///
/// Camera pictures that are labelled with their stage are recognised with their hand given. Seven
/// tenths of them are fitted to and the rest is measured; of several tables, each is measured by
/// what was fitted to the others alone, too. Name tables of different people's hands.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment opening tests/pictures/labels.csv
  grasp-query experiment opening tests/pictures/labels.csv --out opening.toml --json

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where a table or a picture of it could not be used.")]
pub(super) struct OpeningArguments {
    /// Tables of labelled pictures of hands that the index does not hold.
    #[arg(required = true, value_name = "LABELS.csv")]
    labels: Vec<PathBuf>,
    #[command(flatten)]
    index: IndexFile,
    /// Write what is fitted into this file.
    #[arg(long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
    /// Print the figures as one JSON record.
    #[arg(long)]
    json: bool,
}

impl OpeningArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes = index.catalogue().class_names();
        let tables = Selection::all_of(&self.labels, &classes)?;
        if let Some(out) = &self.out {
            let files: Vec<PathBuf> = tables.iter().flat_map(Selected::files).collect();
            let read = self.labels.iter().chain(&files).map(PathBuf::as_path);
            check_file(out, read.chain([self.index.path().as_path()]))?;
        }
        let (mut samples, mut status) = (Vec::new(), SUCCESS);
        for (number, (table, path)) in tables.iter().zip(&self.labels).enumerate() {
            let path = path.display();
            for row in &table.broken {
                status = ERROR;
                error!("{path}, {row}");
            }
            for outcome in with_hands_given(table, &index, global)? {
                match &outcome.result {
                    Err(miss) if !miss.is_rejection => {
                        status = ERROR;
                        error!("{path}, line {}: {}", outcome.label.line, miss.message);
                    }
                    _ => samples.extend(Sample::new(number, &outcome, &classes, Opening::built_in())),
                }
            }
        }
        if samples.is_empty() {
            bail!(
                "no camera picture of these tables says what an open hand looks like: pictures must be \
                 labelled with a stage (reach, close or grasp), and the index must know stages"
            );
        }
        let fitted = Fitted::new(&samples, &self.tables(), &classes);
        if let Some(out) = &self.out {
            fitted.write(out, &self.command(), &index)?;
        }
        print(self.json, &fitted, || fitted.text())?;
        Ok(status)
    }

    fn tables(&self) -> Vec<String> {
        self.labels.iter().map(|path| without_folders(path)).collect()
    }

    /// The command that repeats the fit, without folders that are only here.
    fn command(&self) -> String {
        format!("grasp-query experiment opening {} --out opening.toml", self.tables().join(" "))
    }
}

/// Recognises the camera pictures of a table, each as the hand that it is labelled with.
fn with_hands_given(table: &Selected, index: &Index, global: &Global) -> anyhow::Result<Vec<Outcome>> {
    let mut outcomes = Vec::new();
    for (side, hand) in [(Side::Left, HandChoice::Left), (Side::Right, HandChoice::Right)] {
        let is_meant = |label: &&Label| label.kind == Kind::Camera && label.hand.unwrap_or_default() == side;
        let labels = table.labels.iter().filter(is_meant).cloned().collect();
        let shown = Selected { labels, broken: Vec::new(), folder: table.folder.clone() };
        let options =
            RecogniseOptions { hand, accept: Accept::Always, temper: false, ..RecogniseOptions::default() };
        outcomes.extend(shown.score(&Recogniser::new(index, options), false, global)?);
    }
    Ok(outcomes)
}
