//! What is indexed and searched for: hand shapes by our own renderer, each in a file of its own so that stopped work goes
//! on where it was, or arrays of raw descriptors.

use std::fs::File;
use std::io::{BufReader, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::npy::{NpyHeader, NpyType};
use grasp_index::{AtomicFile, BACKGROUND, DESCRIBED_SIDE, DescriptorParams, HandImage, HandImageError};
use grasp_renders::{HandShape, Look, Preset, RenderPlan, ViewGrid};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::Settings;
use crate::interrupt;
use crate::progress::Progress;

/// Views of a hand shape in the paper's plan: how many entries a hand shape makes, but for some that show no hand.
const VIEWS: u64 = 5400;
const QUERIES: usize = 1000;
/// Hand shapes that are asked for, and never indexed: the index's own are counted up from 0.
const ASKED: Range<u64> = 1_000_000..1_000_008;
/// Hand shapes that an index is tuned by: neither indexed nor asked for.
const TUNED_BY: Range<u64> = 2_000_000..2_000_004;
/// How far a query is moved along the difference of two others. Descriptors of one renderer lie closer to each other than
/// to pictures from elsewhere; moved so, their nearest neighbours are as far as those of real pictures.
const MOVED: Range<f32> = 0.15..0.40;
/// Rows that are read at a time.
const PIECE: u64 = 1 << 14;

/// Where descriptors come from.
#[derive(Clone, Debug)]
pub enum Data {
    /// Rendered: the paper's 6 x 900 views of as many hand shapes as are needed, and queries of others.
    Rendered,
    /// Arrays of rows.
    Files {
        /// What is indexed.
        descriptors: PathBuf,
        /// What is searched for.
        queries: PathBuf,
    },
}

impl Data {
    /// How many descriptors there are; as many as anybody wants where they are rendered.
    ///
    /// # Errors
    /// Where the array cannot be read.
    pub fn most(&self) -> anyhow::Result<u64> {
        match self {
            Self::Rendered => Ok(u64::MAX),
            Self::Files { descriptors, .. } => Ok(open(descriptors)?.0.rows),
        }
    }

    /// By which results of the same data know each other.
    #[must_use]
    pub fn name(&self, seed: u64) -> String {
        match self {
            Self::Rendered => format!("rendered, seed {seed}"),
            Self::Files { descriptors, queries } => {
                format!("{} by {}, seed {seed}", descriptors.display(), queries.display())
            }
        }
    }
}

/// Descriptors of an index, and what to search it for.
#[derive(Debug)]
pub struct Prepared {
    /// What is indexed.
    pub base: Base,
    /// Rows of the same length.
    pub queries: Vec<f32>,
    /// Rows that the index may be tuned by; none where all that is known is indexed.
    pub held_out: Vec<f32>,
}

/// Descriptors on the disk.
#[derive(Debug)]
pub struct Base {
    /// Values of a row.
    pub dim: usize,
    /// How many rows there are.
    pub rows: u64,
    /// The files that hold them, one after the other; only the first so many rows of each count.
    files: Vec<(PathBuf, u64)>,
}

impl Base {
    /// Calls `take` with every row, in order.
    ///
    /// # Errors
    /// Where a file cannot be read, and what `take` returns.
    pub fn each(&self, mut take: impl FnMut(&[f32]) -> anyhow::Result<()>) -> anyhow::Result<()> {
        for (path, rows) in &self.files {
            let (header, mut reader) = open(path)?;
            let mut done = 0;
            while done < *rows {
                let piece = NpyHeader { rows: PIECE.min(rows - done), ..header };
                let values = piece.read_values(&mut reader);
                let values = values.with_context(|| format!("{}, from row {done} on", path.display()))?;
                values.chunks_exact(self.dim).try_for_each(&mut take)?;
                done += piece.rows;
                interrupt::check()?;
            }
        }
        Ok(())
    }
}

/// The first `size` descriptors, as near as whole hand shapes come to that, and the queries.
pub(super) fn prepare(
    settings: &Settings,
    size: u64,
    work: &Path,
    progress: Progress,
) -> anyhow::Result<Prepared> {
    match &settings.data {
        Data::Rendered => rendered(settings, size, work, progress),
        Data::Files { descriptors, queries } => given(descriptors, queries, size),
    }
}

fn given(descriptors: &Path, queries: &Path, size: u64) -> anyhow::Result<Prepared> {
    let (header, _) = open(descriptors)?;
    let (asked, mut reader) = open(queries)?;
    if asked.columns != header.columns {
        bail!(
            "{} has rows of {} values, {} of {}: they must be alike",
            descriptors.display(),
            header.columns,
            queries.display(),
            asked.columns
        );
    }
    if size > header.rows {
        bail!(
            "{} holds {} rows, {size} are asked for: lower --largest or --sizes",
            descriptors.display(),
            header.rows
        );
    }
    let queries = asked.read_values(&mut reader).with_context(|| queries.display().to_string())?;
    let base =
        Base { dim: header.columns as usize, rows: size, files: vec![(descriptors.to_path_buf(), size)] };
    Ok(Prepared { base, queries, held_out: Vec::new() })
}

fn open(path: &Path) -> anyhow::Result<(NpyHeader, BufReader<File>)> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    let mut reader = BufReader::with_capacity(1 << 20, file);
    let header = NpyHeader::read(&mut reader, NpyType::F32)
        .with_context(|| format!("cannot use {}", path.display()))?;
    Ok((header, reader))
}

fn rendered(settings: &Settings, size: u64, work: &Path, progress: Progress) -> anyhow::Result<Prepared> {
    let hands = (size as f64 / VIEWS as f64).round().max(1.0) as usize;
    let params = DescriptorParams::default();
    let plan = RenderPlan { seed: settings.seed, ..RenderPlan::preset(Preset::Paper).with_hands(hands) };
    let bar = progress.bar(hands as u64, "rendering", "hand shapes");
    let mut base = Base { dim: params.dim(), rows: 0, files: Vec::new() };
    for (number, shape) in plan.hand_shapes.iter().enumerate() {
        let path = work.join(format!("hand-{number:04}.npy"));
        // Files are written whole or not at all: one that is there is of an earlier, stopped run.
        if !path.exists() {
            let plan = RenderPlan { hand_shapes: vec![shape.clone()], ..plan.clone() };
            write(&path, &describe(&plan, &params)?, params.dim())?;
        }
        let (header, _) = open(&path)?;
        base.rows += header.rows;
        base.files.push((path, header.rows));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let kept = |name: &str, make: &dyn Fn() -> anyhow::Result<Vec<f32>>| -> anyhow::Result<Vec<f32>> {
        let path = work.join(name);
        if !path.exists() {
            write(&path, &make()?, params.dim())?;
        }
        let (header, mut reader) = open(&path)?;
        Ok(header.read_values(&mut reader)?)
    };
    let queries = kept("queries.npy", &|| {
        Ok(moved(&others(ASKED, settings.seed, &params)?, settings.seed, params.dim()))
    })?;
    let held_out = kept("held-out.npy", &|| others(TUNED_BY, settings.seed, &params))?;
    Ok(Prepared { base, queries, held_out })
}

/// Views of other hand shapes, from between the index's views, in another light.
fn others(shapes: Range<u64>, seed: u64, params: &DescriptorParams) -> anyhow::Result<Vec<f32>> {
    let plan = RenderPlan {
        hand_shapes: shapes.map(HandShape::sample).collect(),
        grid: ViewGrid { step_deg: 17.0, elevation_deg: [3.0, 81.0], ..ViewGrid::default() },
        look: Look { distance_variation: 0.2, light_variation: 0.3, ..Look::default() },
        seed,
        ..RenderPlan::preset(Preset::Paper)
    };
    describe(&plan, params)
}

/// Queries: some of the rows, evenly spread over them, each moved a little.
fn moved(all: &[f32], seed: u64, dim: usize) -> Vec<f32> {
    let rows: Vec<&[f32]> = all.chunks_exact(dim).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut moved = Vec::with_capacity(QUERIES * dim);
    for n in 0..QUERIES.min(rows.len()) {
        let mut any = || rng.random_range(0..rows.len() as u64) as usize;
        let (from, to) = (any(), any());
        let row = |at: usize| rows.get(at).copied().unwrap_or_default();
        let step: Vec<f32> = row(from).iter().zip(row(to)).map(|(from, to)| to - from).collect();
        let length = step.iter().map(|value| value * value).sum::<f32>().sqrt().max(f32::MIN_POSITIVE);
        let scale = rng.random_range(MOVED) / length;
        let at = row(n * rows.len() / QUERIES.min(rows.len()));
        moved.extend(at.iter().zip(&step).map(|(value, step)| value + scale * step));
    }
    moved
}

/// The descriptors of all renders of a plan, in its order, without those that show no hand.
fn describe(plan: &RenderPlan, params: &DescriptorParams) -> anyhow::Result<Vec<f32>> {
    let views = plan.views();
    let mut all = Vec::new();
    for spec in plan.scenes() {
        interrupt::check()?;
        let scene = spec.build().context("cannot render")?;
        let described: Vec<Option<Vec<f32>>> = views
            .par_iter()
            .map(|view| {
                let render = scene.render(view);
                match HandImage::from_segmented(render.side, render.side, &render.grey, BACKGROUND) {
                    Ok(hand) => Ok(Some(params.describe(&hand.shrunk_to(DESCRIBED_SIDE)))),
                    Err(HandImageError::NoHand { .. } | HandImageError::TooSmall { .. }) => Ok(None),
                    Err(error) => Err(error),
                }
            })
            .collect::<Result<_, _>>()?;
        all.extend(described.into_iter().flatten().flatten());
    }
    Ok(all)
}

fn write(path: &Path, values: &[f32], dim: usize) -> anyhow::Result<()> {
    let rows = (values.len() / dim.max(1)) as u64;
    let header = NpyHeader { element: NpyType::F32, rows, columns: dim as u64, offset: 0 };
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mut file = AtomicFile::create(path)?;
    let written = file.write_all(&header.to_bytes()).and_then(|()| file.write_all(&bytes));
    written.with_context(|| format!("cannot write {}", path.display()))?;
    Ok(file.commit()?)
}
