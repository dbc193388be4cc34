//! What is indexed and searched for: hand shapes by our own renderer, each in a file of its own so
//! that stopped work goes on where it was, or arrays of raw descriptors.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::{DescriptorModel, DescriptorParams, HandImageError};
use grasp_renders::{Preset, RENDERER_VERSION, RenderPlan};
use grasp_terminal::Progress;
use rayon::prelude::*;

use crate::array::{self, Rows};
use crate::descriptor::hand_in;
use crate::held_out::{self, Hands};
use crate::interrupt;

/// Views of a hand shape in the paper's plan: how many entries a hand shape makes, but for some
/// that show no hand.
const VIEWS: u64 = 5400;
const QUERIES: usize = 1000;
/// Hand shapes that are asked for: neither indexed, nor those that an index is tuned by.
const ASKED: usize = 8;

/// Where descriptors come from.
#[derive(Clone, Debug)]
pub enum Data {
    /// Rendered: the paper's 6 x 900 views of as many hand shapes as are needed, and queries of
    /// others.
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
            Self::Files { descriptors, .. } => Ok(Rows::open(descriptors)?.len()),
        }
    }

    /// The key under which results of the same data are kept.
    ///
    /// # Errors
    /// Where an array cannot be read.
    pub fn name(&self, seed: u64) -> anyhow::Result<String> {
        Ok(match self {
            Self::Rendered => format!("rendered by version {RENDERER_VERSION}, seed {seed}"),
            Self::Files { descriptors, queries } => {
                // Another array of the same name is other data.
                let hashed = |path: &Path| -> anyhow::Result<String> {
                    let xxh3 = Rows::open(path)?.digest().with_context(|| cannot_use(path))?;
                    Ok(format!("{} ({xxh3:016x})", path.display()))
                };
                format!("{} by {}, seed {seed}", hashed(descriptors)?, hashed(queries)?)
            }
        })
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
        for (path, wanted) in &self.files {
            let mut rows = Rows::open(path)?;
            let mut left = *wanted;
            while left > 0
                && let Some(values) = rows.next().with_context(|| cannot_use(path))?
            {
                let taken = left.min((values.len() / self.dim) as u64);
                values.chunks_exact(self.dim).take(taken as usize).try_for_each(&mut take)?;
                left -= taken;
                interrupt::check()?;
            }
        }
        Ok(())
    }
}

/// The first `size` descriptors, as near as whole hand shapes come to that, and the queries.
pub(super) fn prepare(
    data: &Data,
    seed: u64,
    size: u64,
    work: &Path,
    progress: Progress,
) -> anyhow::Result<Prepared> {
    match data {
        Data::Rendered => rendered(seed, size, work, progress),
        Data::Files { descriptors, queries } => given(descriptors, queries, size),
    }
}

fn given(descriptors: &Path, queries: &Path, size: u64) -> anyhow::Result<Prepared> {
    let (indexed, asked) = (Rows::open(descriptors)?, Rows::open(queries)?);
    if asked.columns() != indexed.columns() {
        bail!(
            "{} has rows of {} values, {} of {}: they must be alike",
            descriptors.display(),
            indexed.columns(),
            queries.display(),
            asked.columns()
        );
    }
    let dim = usize::try_from(indexed.columns())?;
    let base = Base { dim, rows: size, files: vec![(descriptors.to_path_buf(), size)] };
    let queries = asked.all().with_context(|| cannot_use(queries))?;
    Ok(Prepared { base, queries, held_out: Vec::new() })
}

fn cannot_use(path: &Path) -> String {
    format!("cannot use {}", path.display())
}

fn rendered(seed: u64, size: u64, work: &Path, progress: Progress) -> anyhow::Result<Prepared> {
    let hands = (size as f64 / VIEWS as f64).round().max(1.0) as usize;
    let model = DescriptorModel::new(DescriptorParams::default())?;
    let params = *model.params();
    let plan = RenderPlan { seed, ..RenderPlan::preset(Preset::Paper).with_hands(hands) };
    // Files are written whole or not at all: one that is there is of an earlier, stopped run.
    let kept = |name: &str, make: &dyn Fn() -> anyhow::Result<Vec<f32>>| -> anyhow::Result<(PathBuf, Rows)> {
        let path = work.join(name);
        if !path.exists() {
            write(&path, &make()?, params.dim())?;
        }
        let rows = Rows::open(&path)?;
        Ok((path, rows))
    };
    let bar = progress.bar(hands as u64, "rendering", "hand shapes");
    let mut base = Base { dim: params.dim(), rows: 0, files: Vec::new() };
    for (number, shape) in plan.hand_shapes.iter().enumerate() {
        let plan = RenderPlan { hand_shapes: vec![shape.clone()], ..plan.clone() };
        let (path, rows) = kept(&format!("hand-{number:04}.npy"), &|| describe(&plan, &model))?;
        base.rows += rows.len();
        base.files.push((path, rows.len()));
        bar.inc(1);
    }
    drop(bar);
    let tuned_by = Hands::beside(&plan, &[], held_out::HANDS, held_out::VIEWS, seed);
    let asked = Hands::beside(&plan, &tuned_by.names(), ASKED, QUERIES, seed);
    let (_, tuned_by) = kept("held-out.npy", &|| Ok(tuned_by.describe(&model)?.descriptors))?;
    let (_, asked) = kept("queries.npy", &|| {
        Ok(held_out::moved(&asked.describe(&model)?.descriptors, params.dim(), seed))
    })?;
    Ok(Prepared { base, queries: asked.all()?, held_out: tuned_by.all()? })
}

/// The descriptors of all renders of a plan, in its order, without those that show no hand.
fn describe(plan: &RenderPlan, model: &DescriptorModel) -> anyhow::Result<Vec<f32>> {
    let mut all = Vec::new();
    let describer = model.describer();
    let side = model.params().described_side();
    for spec in plan.scenes() {
        let views = plan.views(&spec);
        interrupt::check()?;
        let scene = spec.build().context("cannot render")?;
        let described: Vec<Option<Vec<f32>>> = views
            .par_iter()
            .map_init(
                || describer.clone(),
                |describer, view| {
                    let render = scene.render(view);
                    let hand = hand_in(render.side, render.side, &render.grey)?;
                    Ok(hand.map(|hand| describer.describe(&hand.shrunk_to(side))))
                },
            )
            .collect::<Result<_, HandImageError>>()?;
        all.extend(described.into_iter().flatten().flatten());
    }
    Ok(all)
}

fn write(path: &Path, values: &[f32], dim: usize) -> anyhow::Result<()> {
    let mut rows = values.chunks_exact(dim);
    array::write(path, (values.len() / dim) as u64, dim, |_, row| {
        row.extend_from_slice(rows.next().unwrap_or_default());
        Ok(())
    })
}
