//! `grasp-query experiment`.

use std::io::{self, Write as _};
use std::path::PathBuf;

use anyhow::bail;
use clap::Subcommand;
use grasp_index::Index;
use serde::Serialize;

use super::Global;
use super::index_file::{self, IndexFile};
use super::options::{FrameArguments, RecogniseArguments};
use super::robot_experiment::{ImitationArguments, RobustnessArguments};
use super::selection::{Selected, Selection};
use crate::experiment::paper::{Class, Paper};
use crate::experiment::sequence::Sequences;
use crate::experiment::shapes::{Scored, Shapes};
use crate::experiment::unknown::Unknown;
use crate::recognise::{Accept, RecogniseOptions, Recogniser};

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
    Robustness(RobustnessArguments),
    Imitation(ImitationArguments),
    Sequence(SequenceArguments),
}

/// The paper's Section VII: accuracy, confusion and orientation on X, X' and X'', beside what it reports.
///
/// X is every selected picture, X' those of the stages close and grasp, X'' those of the stage grasp. Segmented and camera
/// pictures are reported separately. With --out, DIR gets paper.csv, confusion.csv, orientation.csv, paper.json, confusion.svg
/// (Figure 7) and orientation.svg (Figure 8).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment paper tests/pictures/labels.csv
  grasp-query experiment paper tests/pictures/labels.csv --hand right --out results
  grasp-query experiment paper tests/pictures/labels.csv --part final --where kind=segmented --json

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

/// Hand shapes against accuracy: the same labelled pictures, recognised by indexes of ever more hand shapes.
///
/// How many an index holds is read from it; `grasp-builder experiment shapes` builds such indexes. With --out, DIR gets
/// shapes.csv, shapes.json and shapes.svg.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment shapes --out shapes --counts 1,3,10
  grasp-query experiment shapes tests/pictures/labels.csv \\
    --index shapes/hands-0001.idx --index shapes/hands-0003.idx --index shapes/hands-0010.idx --hand right --out results

LABELS.csv is as for `grasp-query evaluate`. Exit status: 0, or 2 where the table or a picture of it could not be used.")]
struct ShapesArguments {
    #[command(flatten)]
    selection: Selection,
    /// An index to recognise the pictures by; several may be named.
    #[arg(long = "index", value_name = "FILE", required = true)]
    indexes: Vec<PathBuf>,
    /// Write table and drawing into this folder; made where there is none.
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

/// How well known hands are distinguished from others, by the distance of the nearest entry and by the probability.
///
/// Known are the pictures labelled with a class of the index, others those labelled `other` and those of --others. With --out,
/// DIR gets unknown.csv, unknown.json and unknown.svg: the share of known hands kept over that of others, at every limit.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment unknown tests/pictures/labels.csv
  grasp-query experiment unknown tests/pictures/labels.csv --hand right --others OTHERS.csv --out results

LABELS.csv and OTHERS.csv are as for `grasp-query evaluate`; of OTHERS.csv every row counts, and its labels do not.
Exit status: 0, or 2 where a table or a picture of it could not be used.")]
struct UnknownArguments {
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    index: IndexFile,
    /// A table of pictures that show none of the grasps, whatever they are labelled.
    #[arg(long, value_name = "OTHERS.csv")]
    others: Option<PathBuf>,
    /// Write table and drawing into this folder; made where there is none.
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

/// What the frames before are worth: views of a grasp at the stages reach, close and grasp, recognised one by one and in this order.
///
/// A sequence is a view (azimuth, elevation, roll) of a grasp of which all three stages are labelled. With --out, DIR gets
/// sequence.csv and sequence.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query experiment sequence tests/pictures/labels.csv --hand right
  grasp-query experiment sequence tests/pictures/labels.csv --hand right --switch 0.4 --json

LABELS.csv is as for `grasp-query evaluate`. Exit status: 0, or 2 where the table or a picture of it could not be used.")]
struct SequenceArguments {
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    index: IndexFile,
    #[command(flatten)]
    frames: FrameArguments,
    /// Write the table into this folder; made where there is none.
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
            Name::Shapes(shapes) => shapes.run(global),
            Name::Unknown(unknown) => unknown.run(global),
            Name::Robustness(robustness) => robustness.run(global),
            Name::Imitation(imitation) => imitation.run(global),
            Name::Sequence(sequence) => sequence.run(global),
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
        print(self.json, &paper, || paper.text())?;
        Ok(if paper.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}

impl ShapesArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let names = |index: &Index| -> Vec<String> {
            index.catalogue().classes.iter().map(|class| class.name.clone()).collect()
        };
        // All of them first: a wrong name should not be found out after the work.
        let mut indexes: Vec<(&PathBuf, Index)> = Vec::new();
        for path in &self.indexes {
            indexes.push((path, index_file::open_for_pictures(path, false)?));
        }
        let classes = indexes.first().map(|(_, index)| names(index)).unwrap_or_default();
        if let Some((path, _)) = indexes.iter().find(|(_, index)| names(index) != classes) {
            bail!(
                "{} has other classes than the first index: name indexes of the same grasps",
                path.display()
            );
        }
        let selected = self.selection.read(&classes)?;
        let scored: Vec<Scored> = indexes
            .iter()
            .map(|(path, index)| Scored {
                index: path.display().to_string(),
                hand_shapes: index.catalogue().hand_shapes.len(),
                entries: index.len(),
                outcomes: selected.score(
                    &Recogniser::new(index, self.recognise.options()),
                    self.labelled_masks,
                    global,
                ),
            })
            .collect();
        let labels = self.selection.path().display().to_string();
        let shapes = Shapes::new(labels, &classes, &scored, &selected.broken);
        if let Some(folder) = &self.out {
            shapes.write(folder)?;
        }
        print(self.json, &shapes, || shapes.text())?;
        Ok(if shapes.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}

impl UnknownArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes: Vec<String> = index.catalogue().classes.iter().map(|class| class.name.clone()).collect();
        let selected = self.selection.read(&classes)?;
        let others = self.others.as_ref().map(|path| Selected::others(path)).transpose()?;
        // What is measured here must not have been decided before.
        let options = RecogniseOptions { accept: Accept::Always, ..self.recognise.options() };
        let recogniser = Recogniser::new(&index, options);
        let mut outcomes = selected.score(&recogniser, self.labelled_masks, global);
        let mut broken = selected.broken.clone();
        if let Some(others) = others {
            outcomes.extend(others.score(&recogniser, self.labelled_masks, global));
            broken.extend(others.broken);
        }
        let calibration = index.catalogue().calibration;
        let limits = calibration.farthest.map(|farthest| (farthest, calibration.least_probability));
        let unknown = Unknown::new(self.selection.path().display().to_string(), &outcomes, &broken, limits);
        if let Some(folder) = &self.out {
            unknown.write(folder)?;
        }
        print(self.json, &unknown, || unknown.text())?;
        Ok(if unknown.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}

impl SequenceArguments {
    fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let index = self.index.open_for_pictures()?;
        let classes: Vec<String> = index.catalogue().classes.iter().map(|class| class.name.clone()).collect();
        let selected = self.selection.read(&classes)?;
        // A frame that is unknown by itself may count for something with the others.
        let options = RecogniseOptions { accept: Accept::Always, ..self.recognise.options() };
        let recogniser = Recogniser::new(&index, options);
        let outcomes = selected.score(&recogniser, self.labelled_masks, global);
        let labels = self.selection.path().display().to_string();
        let sequences = Sequences::new(labels, &outcomes, &selected.broken, self.frames.params());
        if let Some(folder) = &self.out {
            sequences.write(folder)?;
        }
        print(self.json, &sequences, || sequences.text())?;
        Ok(if sequences.errors.is_empty() { super::SUCCESS } else { super::ERROR })
    }
}

/// The figures on standard output, as a JSON record or as text.
pub(super) fn print(
    json: bool,
    figures: &impl Serialize,
    text: impl FnOnce() -> String,
) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, figures).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        write!(out, "{}", text())?;
    }
    Ok(())
}
