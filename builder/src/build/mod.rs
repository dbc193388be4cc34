//! From pictures to an index.
//!
//! A [`Source`] lists what to index, in a fixed order. Its pictures are described in parallel and collected in that
//! order, so that the file's bytes do not depend on the number of threads. What an existing index at the same path
//! holds of the very same pictures (`known`) is taken over instead of being rendered and described again; the bytes
//! are those of a build from nothing.

mod inputs;
mod known;
mod labels;
mod planned;
mod sets;
mod vectors;

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use grasp_index::{
    AtomicFile, BACKGROUND, BuildError, ClassInfo, DESCRIBED_SIDE, DescriptorParams, HandImage,
    HandImageError, HashParams, IndexParams, IndexWriter, Kept, NewEntry, Originals, Phase, Summary,
};
use grasp_renders::RenderPlan;

use crate::held_out::HeldOut;
use crate::interrupt::{self, Interrupted};
use crate::progress::Progress;
use inputs::Inputs;
use known::Known;

pub use sets::{RenderSet, SetError};
pub use vectors::Vectors;

/// The side of the thumbnails that an index keeps for showing its neighbours, in pixels.
pub const THUMBNAIL_SIDE: u32 = 48;

/// Where the pictures come from.
#[derive(Debug)]
pub enum Source {
    /// Rendered on the fly; no picture is written.
    Plan(Box<RenderPlan>),
    /// Read from the disk.
    Sets(Vec<RenderSet>),
    /// Described elsewhere.
    Vectors(Box<Vectors>),
}

/// What kind of index to make of them.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// How hand images are described.
    pub descriptor: DescriptorParams,
    /// How the hash is sized.
    pub hash: HashParams,
    /// Which form of the descriptors is kept.
    pub originals: Originals,
    /// What the search is measured by.
    pub held_out: HeldOut,
    /// The side of the thumbnails in pixels; 0 keeps none.
    pub thumbnail_side: u32,
    /// What all randomness comes from.
    pub seed: u64,
}

/// What a build did.
#[derive(Debug)]
pub struct Report {
    /// The written index; `None` where the existing file was up to date and was left alone.
    pub written: Option<Summary>,
    /// Entries of the index.
    pub entries: usize,
    /// Entries whose picture was known to the existing index.
    pub reused: usize,
    /// Pictures that show no hand (a view in which the object hides it) and make no entry.
    pub without_hand: usize,
    /// How long it took.
    pub elapsed: Duration,
}

/// A picture that has become an entry, or shows no hand.
type Described = Option<(NewEntry, bool)>;

/// Builds the index of `source` at `out`.
///
/// # Errors
/// When a picture cannot be read, `out` is a file that is no index, or the index cannot be written. The file at `out`
/// is then as it was before. [`Interrupted`] when the user asked to stop.
pub fn build(source: &Source, recipe: &Recipe, out: &Path, progress: Progress) -> anyhow::Result<Report> {
    let started = Instant::now();
    // Locked before hours of work, not after them.
    let file = AtomicFile::create(out)?;
    let known = Known::at(out, recipe)?;
    let names = match source {
        Source::Plan(plan) => planned::names(plan)?,
        Source::Sets(sets) => sets::names(sets)?,
        Source::Vectors(vectors) => vectors::names(vectors),
    };
    let mut collected = Collector::new(file, source, &names, recipe)?;
    let (doing, unit) = match source {
        Source::Plan(_) | Source::Sets(_) => ("describing", "views"),
        Source::Vectors(_) => ("reading", "rows"),
    };
    let bar = progress.bar(source.len() as u64, doing, unit);
    let mut take = |batch: Vec<Described>| -> anyhow::Result<()> {
        bar.inc(batch.len() as u64);
        interrupt::check()?;
        collected.take(batch)
    };
    match source {
        Source::Plan(plan) => planned::describe(plan, &names, recipe, &known, &mut take)?,
        Source::Sets(sets) => sets::describe(sets, &names, recipe, &known, &mut take)?,
        Source::Vectors(vectors) => vectors::describe(vectors, &mut take)?,
    }
    bar.finish_and_clear();

    let Collector { mut writer, inputs, mut report } = collected;
    if report.entries == 0 {
        bail!("none of the {} pictures shows a hand: nothing to index", report.without_hand);
    }
    if known.is_made_from(&inputs) {
        report.elapsed = started.elapsed();
        return Ok(report);
    }
    writer.add_provenance(inputs.provenance());
    let spinner = progress.spinner("rendering held-out hands");
    let asked = recipe.held_out.describe(&recipe.descriptor)?;
    // Where a set shows other grasps than its grasps' own file tells of, what is held out says nothing about its vote.
    let classes: anyhow::Result<Vec<u16>> = asked.grasps.iter().map(|grasp| names.class(grasp)).collect();
    writer.hold_out(asked.descriptors, classes.unwrap_or_default())?;
    spinner.finish_and_clear();
    let spinner = progress.spinner("hashing");
    let summary = writer.finish(&|phase, _| {
        spinner.set_message(match phase {
            Phase::Sigma => "measuring sigma",
            Phase::Tune => "choosing the hash",
            Phase::Tables => "filling the hash tables",
            Phase::Measure => "measuring the search",
            Phase::Calibrate => "calibrating the vote",
            _ => "writing",
        });
        if interrupt::check().is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    spinner.finish_and_clear();
    let summary = match summary {
        Err(BuildError::Stopped) => return Err(Interrupted.into()),
        other => other.with_context(|| format!("{} was not written", out.display()))?,
    };
    report.written = Some(summary);
    report.elapsed = started.elapsed();
    Ok(report)
}

impl Source {
    /// How many pictures there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Plan(plan) => plan.renders(),
            Self::Sets(sets) => sets.iter().map(RenderSet::len).sum(),
            Self::Vectors(vectors) => vectors.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Gathers described pictures into a writer, in the order of the source.
struct Collector {
    writer: IndexWriter,
    inputs: Inputs,
    report: Report,
}

impl Collector {
    fn new(file: AtomicFile, source: &Source, names: &Names, recipe: &Recipe) -> anyhow::Result<Self> {
        let params = IndexParams {
            descriptor: recipe.descriptor,
            classes: names.classes.clone(),
            hand_shapes: names.hand_shapes.names.clone(),
            stages: names.stages.names.clone(),
            hash: recipe.hash,
            originals: recipe.originals,
            kept: names.kept,
            seed: recipe.seed,
            thumbnail_side: recipe.thumbnail_side,
            ..IndexParams::default()
        };
        let inputs = Inputs::new(source, &params, recipe.held_out.provenance()?);
        let report =
            Report { written: None, entries: 0, reused: 0, without_hand: 0, elapsed: Duration::default() };
        Ok(Self { writer: IndexWriter::create_in(file, params)?, inputs, report })
    }

    fn take(&mut self, batch: Vec<Described>) -> anyhow::Result<()> {
        for described in batch {
            let Some((entry, reused)) = described else {
                self.report.without_hand += 1;
                continue;
            };
            self.inputs.add(&entry);
            self.writer.push(entry)?;
            self.report.entries += 1;
            self.report.reused += usize::from(reused);
        }
        Ok(())
    }
}

/// The names that entries refer to by number.
#[derive(Clone, Debug, Default)]
struct Names {
    /// What is known of the entries.
    kept: Kept,
    classes: Vec<ClassInfo>,
    hand_shapes: Numbered,
    stages: Numbered,
}

/// Names in the order of their first use; a name's number is its position.
#[derive(Clone, Debug, Default)]
struct Numbered {
    names: Vec<String>,
    numbers: HashMap<String, usize>,
}

impl Names {
    fn class(&self, name: &str) -> anyhow::Result<u16> {
        number(self.classes.iter().position(|class| class.name == name), name)
    }

    fn hand_shape(&self, name: &str) -> anyhow::Result<u16> {
        number(self.hand_shapes.numbers.get(name).copied(), name)
    }

    fn stage(&self, name: &str) -> anyhow::Result<u8> {
        number(self.stages.numbers.get(name).copied(), name)
    }
}

impl Numbered {
    /// More names than that cannot be numbered in the file.
    const MOST: usize = 1 << 16;

    fn add(&mut self, name: &str) -> anyhow::Result<()> {
        if !self.numbers.contains_key(name) {
            if self.names.len() == Self::MOST {
                bail!(
                    "more than {} different hand shapes: split the render sets into several indexes",
                    Self::MOST
                );
            }
            self.numbers.insert(name.to_owned(), self.names.len());
            self.names.push(name.to_owned());
        }
        Ok(())
    }
}

/// A position as the number that stands for it in the file.
fn number<N: TryFrom<usize>>(position: Option<usize>, name: &str) -> anyhow::Result<N> {
    position
        .and_then(|position| N::try_from(position).ok())
        .with_context(|| format!("more names than an index can number, or an unlisted one: {name}"))
}

/// Puts descriptor and thumbnail of a grey picture into `entry`: taken over from the existing index where it knows
/// `entry.source_hash`, made from the picture otherwise. `None` where the picture shows no hand.
fn complete(
    entry: NewEntry,
    recipe: &Recipe,
    known: &Known,
    picture: impl FnOnce() -> anyhow::Result<Grey>,
) -> anyhow::Result<Described> {
    if let Some((descriptor, thumbnail)) = known.get(entry.source_hash) {
        return Ok(Some((NewEntry { descriptor, thumbnail, ..entry }, true)));
    }
    let Grey { width, height, pixels } = picture()?;
    let hand = match HandImage::from_segmented(width, height, &pixels, BACKGROUND) {
        Ok(hand) => hand.shrunk_to(DESCRIBED_SIDE),
        Err(HandImageError::NoHand { .. } | HandImageError::TooSmall { .. }) => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot use {}", entry.file)),
    };
    let descriptor = recipe.descriptor.describe(&hand);
    let thumbnail = (recipe.thumbnail_side > 0).then(|| hand.thumbnail(recipe.thumbnail_side as usize));
    Ok(Some((NewEntry { descriptor, thumbnail, ..entry }, false)))
}

/// A grey picture, row by row.
struct Grey {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}
