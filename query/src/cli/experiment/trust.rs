//! `grasp-query experiment trust`.

use std::path::PathBuf;

use rayon::prelude::*;
use tracing::error;

use crate::cli::figures::print;
use crate::cli::index_file::IndexFile;
use crate::cli::options::{SegmentArguments, parse_probability};
use crate::cli::outputs::check_file;
use crate::cli::selection::{Selected, Selection, without_folders};
use crate::evaluate::labels::Kind;
use crate::experiment::trust::{Fitted, HANDS_PER_NONE, Recognisers};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::Trust;

/// How far to trust an answer about a camera picture: fits the models that the program holds in
/// query/recognise/data: trust-scene.toml, and for --segment skin trust-learned.toml and, for
/// descriptors of gradients, trust.toml.
///
/// Camera pictures are recognised as they are; segmented ones are put in front of backgrounds that
/// are hard to tell from skin, and such backgrounds are tried alone. The model is fitted to seven
/// tenths of them all and measured on the rest.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment trust tests/pictures/labels.csv
  grasp-query experiment trust tests/pictures/labels.csv --out trust.toml

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where a table or a picture of it could not be used.")]
pub(super) struct TrustArguments {
    /// Tables of labelled pictures, of both kinds, of hands that the index does not hold.
    #[arg(required = true, value_name = "LABELS.csv")]
    labels: Vec<PathBuf>,
    #[command(flatten)]
    index: IndexFile,
    #[command(flatten)]
    segment: SegmentArguments,
    /// The trust below which a hand is unknown; without it, that of the model that is replaced.
    #[arg(long, value_name = "P", value_parser = parse_probability, allow_negative_numbers = true)]
    least: Option<f64>,
    /// The least that probabilities are tempered by, however little an answer is trusted; without
    /// it, that of the model that is replaced.
    #[arg(long, value_name = "P", value_parser = parse_probability, allow_negative_numbers = true)]
    floor: Option<f64>,
    /// Write the model into this file.
    #[arg(long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
    /// Print the figures as one JSON record.
    #[arg(long)]
    json: bool,
}

impl TrustArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes = index.catalogue().class_names();
        let tables = Selection::all_of(&self.labels, &classes)?;
        if let Some(out) = &self.out {
            let files: Vec<PathBuf> = tables.iter().flat_map(Selected::files).collect();
            let read = self.labels.iter().chain(&files).map(PathBuf::as_path);
            check_file(out, read.chain([self.index.path().as_path()]))?;
        }
        let segment = self.segment.params()?;
        let before = Trust::of_descriptor(&index.catalogue().descriptor, &segment.by);
        let [least, floor] = [self.least.unwrap_or(before.least), self.floor.unwrap_or(before.floor)];
        let recognisers = Recognisers::new(&index, segment);
        let (mut samples, mut segmented, mut status) = (Vec::new(), 0, SUCCESS);
        for (table, path) in tables.iter().zip(&self.labels) {
            segmented += table.labels.iter().filter(|label| label.kind == Kind::Segmented).count();
            let bar = global.progress().bar(table.labels.len() as u64, "recognising", "pictures");
            let found: Vec<_> = table
                .labels
                .par_iter()
                .map(|label| {
                    let found = recognisers.samples(&table.folder, label);
                    bar.inc(1);
                    found.map_err(|miss| format!("line {}: {}", label.line, miss.message))
                })
                .collect();
            drop(bar);
            let broken = table.broken.iter().map(|row| Err(row.to_string()));
            for found in found.into_iter().chain(broken) {
                match found {
                    Ok(found) => samples.extend(found),
                    Err(message) => {
                        status = ERROR;
                        error!("{}, {message}", path.display());
                    }
                }
            }
        }
        let empty: Vec<_> =
            (0..segmented / HANDS_PER_NONE).into_par_iter().map(|number| recognisers.empty(number)).collect();
        samples.extend(empty.into_iter().flatten());
        let fitted = Fitted::new(&samples, [least, floor]);
        if let Some(out) = &self.out {
            fitted.write(out, &self.command([least, floor]), &index)?;
        }
        print(self.json, &fitted, || fitted.text())?;
        Ok(status)
    }

    /// The command that repeats the fit, without folders that are only here.
    fn command(&self, [least, floor]: [f64; 2]) -> String {
        let labels: Vec<String> = self.labels.iter().map(|path| without_folders(path)).collect();
        let (labels, segment) = (labels.join(" "), self.segment.named());
        format!(
            "grasp-query experiment trust {labels}{segment} --least {least} --floor {floor} --out trust.toml"
        )
    }
}
