//! From pictures to an index.
//!
//! A [`Source`] lists what to index, in a fixed order. Its pictures are described in parallel and collected in that
//! order, so that the file's bytes do not depend on the number of threads. What an existing index at the same path
//! holds of the very same pictures (`known`) is taken over instead of being rendered and described again; the bytes
//! are those of a build from nothing.

mod gather;
mod inputs;
mod known;
mod labels;
mod names;
mod planned;
mod sets;
mod vectors;

use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use grasp_index::{
    AtomicFile, BACKGROUND, DESCRIBED_SIDE, Describer, DescriptorParams, HandImage, HandImageError,
    HashParams, IndexParams, NewEntry, Originals, Summary,
};
use grasp_renders::RenderPlan;
use grasp_terminal::Progress;

use crate::held_out::HeldOut;
use crate::interrupt;
use crate::plan_spec::PlanSpec;

pub(crate) use gather::Gathered;
pub(crate) use inputs::{KEY as INPUTS, OPTIONS, tool};
pub(crate) use known::Known;
use known::KnownPicture;
pub(crate) use names::Names;
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
    /// How the held-out hands are seen, and the index's own if it renders them: the index keeps it
    /// for those that are added later. `None` where no hand is rendered.
    pub seen: Option<PlanSpec>,
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

/// A picture that has become an entry (and whether an existing index knew it), or shows no hand.
pub(crate) type Described = Option<(NewEntry, bool)>;

/// What takes described pictures, in the order of the source.
pub(crate) type Take<'t> = &'t mut dyn FnMut(Vec<Described>) -> anyhow::Result<()>;

/// Builds the index of `source` at `out`.
///
/// # Errors
/// When a picture cannot be read, `out` is a file that is no index, or the index cannot be written. The file at `out`
/// is then as it was before. [`Interrupted`](crate::interrupt::Interrupted) when the user asked to stop.
pub fn build(source: &Source, recipe: &Recipe, out: &Path, progress: Progress) -> anyhow::Result<Report> {
    let started = Instant::now();
    // Locked before hours of work, not after them.
    let file = AtomicFile::create(out)?;
    let known = Known::at(out, &recipe.descriptor, recipe.thumbnail_side)?;
    let names = source.names()?;
    let origin = source.origin(recipe)?;
    let mut gathered = Gathered::new(file, recipe.params(&names), origin)?;
    let (doing, unit) = source.work();
    let bar = progress.bar(source.len() as u64, doing, unit);
    let mut take = |batch: Vec<Described>| -> anyhow::Result<()> {
        bar.inc(batch.len() as u64);
        interrupt::check()?;
        gathered.take(batch)
    };
    source.describe(&names, recipe, &known, 0..source.pieces(), &mut take)?;
    drop(bar);
    let report = gathered.finish(&known, || recipe.asked(&names), progress)?;
    Ok(Report { elapsed: started.elapsed(), ..report })
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

    /// In how many pieces the work can be split: scenes that are to be rendered, pictures or rows. Scenes come hand shape by hand
    /// shape.
    #[must_use]
    pub fn pieces(&self) -> usize {
        match self {
            Self::Plan(plan) => plan.renders() / plan.views.count().max(1),
            Self::Sets(_) | Self::Vectors(_) => self.len(),
        }
    }

    /// What is done with the pictures, and what they are called, for a progress bar.
    pub(crate) fn work(&self) -> (&'static str, &'static str) {
        match self {
            Self::Plan(_) | Self::Sets(_) => ("describing", "views"),
            Self::Vectors(_) => ("reading", "rows"),
        }
    }

    pub(crate) fn names(&self) -> anyhow::Result<Names> {
        match self {
            Self::Plan(plan) => planned::names(plan),
            Self::Sets(sets) => sets::names(sets),
            Self::Vectors(vectors) => Ok(vectors::names(vectors)),
        }
    }

    /// Where an index of this source and recipe comes from, as its provenance says.
    pub(crate) fn origin(&self, recipe: &Recipe) -> anyhow::Result<Vec<(String, String)>> {
        Ok(inputs::origin(self, recipe.held_out.provenance()?, recipe.seen.as_ref()))
    }

    /// A number for all that some of the [`Self::pieces`] are made from: as long as it is the same, so are their entries.
    pub(crate) fn digest(&self, pieces: Range<usize>) -> anyhow::Result<u64> {
        match self {
            Self::Plan(plan) => Ok(planned::digest(plan)),
            Self::Sets(sets) => sets::digest(sets, pieces),
            Self::Vectors(vectors) => vectors::digest(vectors, pieces),
        }
    }

    /// Hands the pictures of some of the [`Self::pieces`] to `take`, described, in order.
    pub(crate) fn describe(
        &self,
        names: &Names,
        recipe: &Recipe,
        known: &Known,
        pieces: Range<usize>,
        take: Take<'_>,
    ) -> anyhow::Result<()> {
        match self {
            Self::Plan(plan) => planned::describe(plan, names, recipe, known, pieces, take),
            Self::Sets(sets) => sets::describe(sets, names, recipe, known, pieces, take),
            Self::Vectors(vectors) => vectors::describe(vectors, pieces, take),
        }
    }
}

impl Recipe {
    /// The parameters of an index whose entries go by `names`.
    pub(crate) fn params(&self, names: &Names) -> IndexParams {
        IndexParams {
            descriptor: self.descriptor,
            classes: names.classes.clone(),
            hand_shapes: names.hand_shapes.names.clone(),
            stages: names.stages.names.clone(),
            hash: self.hash,
            originals: self.originals,
            kept: names.kept,
            seed: self.seed,
            thumbnail_side: self.thumbnail_side,
            ..IndexParams::default()
        }
    }

    /// The held-out descriptors, in rows, and the number of each one's class, where these are known.
    pub(crate) fn asked(&self, names: &Names) -> anyhow::Result<(Vec<f32>, Vec<u16>)> {
        let asked = self.held_out.describe(&self.descriptor)?;
        // Where a set shows other grasps than its grasps' own file tells of, what is held out says nothing about its vote.
        let classes: anyhow::Result<Vec<u16>> = asked.grasps.iter().map(|grasp| names.class(grasp)).collect();
        Ok((asked.descriptors, classes.unwrap_or_default()))
    }
}

/// Puts descriptor and thumbnail of a grey picture into `entry`: taken over from the existing index where it knows
/// `entry.source_hash`, made from the picture otherwise. `None` where the picture shows no hand.
fn complete(
    entry: NewEntry,
    recipe: &Recipe,
    known: &Known,
    picture: impl FnOnce() -> anyhow::Result<Grey>,
) -> anyhow::Result<Described> {
    if let Some(known) = known.get(entry.source_hash, entry.roll_deg) {
        let KnownPicture { descriptor, thumbnail, turn_deg } = known;
        return Ok(Some((NewEntry { descriptor, thumbnail, ..entry.turned(turn_deg) }, true)));
    }
    let Grey { width, height, pixels } = picture()?;
    let hand = match HandImage::from_segmented(width, height, &pixels, BACKGROUND) {
        Ok(hand) => hand.shrunk_to(DESCRIBED_SIDE),
        Err(HandImageError::NoHand { .. } | HandImageError::TooSmall { .. }) => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot use {}", entry.file)),
    };
    let turn_deg = recipe.descriptor.turn_deg(&hand);
    let hand = hand.rotated(turn_deg.to_radians());
    let descriptor = Describer::new(&recipe.descriptor)?.describe_turned(&hand);
    let thumbnail = (recipe.thumbnail_side > 0).then(|| hand.thumbnail(recipe.thumbnail_side as usize));
    Ok(Some((NewEntry { descriptor, thumbnail, ..entry.turned(turn_deg) }, false)))
}

/// A grey picture, row by row.
struct Grey {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}
