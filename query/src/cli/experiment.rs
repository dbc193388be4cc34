//! `grasp-query experiment`.

use std::path::PathBuf;

use anyhow::bail;
use clap::Subcommand;
use grasp_answer::index_file;
use grasp_index::Index;
use rayon::prelude::*;
use tracing::error;

use super::figures::print;
use super::index_file::IndexFile;
use super::labelled::LabelledArguments;
use super::opening_experiment::OpeningArguments;
use super::options::{FrameArguments, SegmentArguments, parse_probability};
use super::outputs::{check_file, make_folder};
use super::report::ReportArguments;
#[cfg(feature = "simulate")]
use super::robot_experiment::{ImitationArguments, RobustnessArguments};
use super::selection::{Selected, Selection, without_folders};
use super::steadiness_experiment::SteadinessArguments;
use crate::evaluate::Outcome;
use crate::evaluate::labels::{Kind, OTHER};
use crate::evaluate::report::RowReport;
use crate::experiment::paper::{Class, Paper};
use crate::experiment::sequence::{self, Sequences};
use crate::experiment::shapes::{Scored, Shapes};
use crate::experiment::trust::{Fitted, HANDS_PER_NONE, Recognisers};
use crate::experiment::unknown::{Limits, Unknown};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::{Accept, RecogniseOptions, Trust};

/// Repeat an experiment, over labelled pictures or in simulation, as tables and drawings.
#[derive(Debug, clap::Args)]
pub(super) struct Experiment {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    Paper(PaperArguments),
    Shapes(ShapesArguments),
    Unknown(UnknownArguments),
    Trust(TrustArguments),
    Opening(OpeningArguments),
    #[cfg(feature = "simulate")]
    Robustness(RobustnessArguments),
    #[cfg(feature = "simulate")]
    Imitation(ImitationArguments),
    Sequence(SequenceArguments),
    Steadiness(SteadinessArguments),
    Report(ReportArguments),
}

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
struct PaperArguments {
    #[command(flatten)]
    index: IndexFile,
    /// Write tables and drawings into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

/// Hand shapes against accuracy: the same labelled pictures, recognised by indexes of ever more
/// hand shapes.
///
/// How many an index holds is read from it; `grasp-builder experiment shapes` builds such indexes.
/// With --out, DIR gets shapes.csv, shapes.json and shapes.svg.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment shapes --out shapes --counts 1,3,10
  grasp-query experiment shapes tests/pictures/labels.csv \\
    --index shapes/hands-0001.idx --index shapes/hands-0003.idx --index shapes/hands-0010.idx \\
    --hand right --out results

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
struct ShapesArguments {
    /// An index to recognise the pictures by; several may be named.
    #[arg(long = "index", value_name = "FILE", required = true)]
    indexes: Vec<PathBuf>,
    /// Write table and drawing into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

/// How well known hands are distinguished from others, by the distance of the nearest entry, by the
/// probability and by the trust in the mask.
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
struct UnknownArguments {
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
struct TrustArguments {
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
struct SequenceArguments {
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

impl Experiment {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        match &self.name {
            Name::Paper(paper) => paper.run(global),
            Name::Shapes(shapes) => shapes.run(global),
            Name::Unknown(unknown) => unknown.run(global),
            Name::Trust(trust) => trust.run(global),
            Name::Opening(opening) => opening.run(global),
            #[cfg(feature = "simulate")]
            Name::Robustness(robustness) => robustness.run(global),
            #[cfg(feature = "simulate")]
            Name::Imitation(imitation) => imitation.run(global),
            Name::Sequence(sequence) => sequence.run(global),
            Name::Steadiness(steadiness) => steadiness.run(global),
            Name::Report(report) => report.run(global),
        }
    }
}

impl PaperArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
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

impl ShapesArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
        // All of them first: a wrong name should not be found out after the work.
        let mut indexes: Vec<(&PathBuf, Index)> = Vec::new();
        for path in &self.indexes {
            indexes.push((path, index_file::open_for_pictures(path, false)?));
        }
        let classes = indexes.first().map(|(_, index)| index.catalogue().class_names()).unwrap_or_default();
        if let Some((path, _)) = indexes.iter().find(|(_, index)| index.catalogue().class_names() != classes)
        {
            bail!(
                "{} has other classes than the first index: name indexes of the same grasps",
                path.display()
            );
        }
        let selected = self.labelled.selection.read(&classes)?;
        if let Some(folder) = &self.out {
            let indexes = self.indexes.iter().map(PathBuf::as_path);
            make_folder(folder, &Shapes::FILES, indexes.chain([self.labelled.selection.path()]))?;
        }
        let options = self.labelled.recognise.options()?;
        let score = |(path, index): &(&PathBuf, Index)| -> anyhow::Result<Scored> {
            Ok(Scored {
                index: path.display().to_string(),
                hand_shapes: index.catalogue().hand_shapes.len(),
                entries: index.len(),
                outcomes: self.labelled.score(&selected, index, options.clone(), global)?,
            })
        };
        let scored: Vec<Scored> = indexes.iter().map(score).collect::<Result<_, _>>()?;
        let shapes = Shapes::new(self.labelled.table(), &classes, &scored, &selected.broken);
        if let Some(folder) = &self.out {
            shapes.write(folder)?;
        }
        print(self.labelled.json, &shapes, || shapes.text())?;
        Ok(if shapes.errors.is_empty() { SUCCESS } else { ERROR })
    }
}

impl UnknownArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
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

impl TrustArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
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

impl SequenceArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
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
