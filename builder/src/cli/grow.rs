//! `grasp-builder add`, `remove` and `compact`.

use std::path::PathBuf;

use anyhow::Context as _;
use grasp_index::Index;
use grasp_renders::{Preset, RenderPlan};

use super::Global;
use super::build::tell;
use super::plan::PlanOptions;
use crate::build::{RenderSet, Source};
use crate::grow::{Growth, grow};
use crate::interrupt;

/// Add render sets or hand shapes to an index.
///
/// What the index holds is taken over, not described again, and its parameters are kept; a picture that it holds already is not added
/// twice. It is replaced in one step, and the answers are those of an index built of the same entries from nothing (to the last
/// bit where it keeps descriptors as they are; --originals f16 hashes rounded ones). With --segment the index is not touched.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder add grasp.idx new-renders
  grasp-builder add grasp.idx --hand-shape slender
  grasp-builder add grasp.idx new-renders --segment new.idx
  grasp-builder compact grasp.idx new.idx --out grasp.idx")]
pub(crate) struct Add {
    /// The index to add to.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// Render sets to add; none renders on the fly.
    #[arg(value_name = "RENDERS", conflicts_with_all = ["hands", "hand_shape", "hand_model", "stage"])]
    renders: Vec<PathBuf>,
    /// Write an index of the added entries alone, which can be searched beside the other and joined to it with `compact`.
    #[arg(long, value_name = "FILE")]
    segment: Option<PathBuf>,
    #[command(flatten)]
    plan: PlanOptions,
}

/// Take all entries of some hand shapes out of an index.
#[derive(Debug, clap::Args)]
pub(crate) struct Remove {
    /// The index, which is replaced in one step.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// The hand shape to remove (may be repeated).
    #[arg(long, value_name = "NAME", required = true)]
    hand_shape: Vec<String>,
    /// The preset that the index was built with: it is measured and calibrated on held-out hands that are seen likewise.
    #[arg(long, default_value_t = Preset::Paper, value_name = "NAME")]
    preset: Preset,
}

/// Join indexes that are alike in everything but their entries.
#[derive(Debug, clap::Args)]
pub(crate) struct Compact {
    /// The indexes, whose entries keep this order.
    #[arg(value_name = "FILE", required = true)]
    indexes: Vec<PathBuf>,
    /// The index to write, which may be one of them.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx")]
    out: PathBuf,
    /// The preset that the indexes were built with: what comes of them is measured and calibrated on held-out hands that are seen likewise.
    #[arg(long, default_value_t = Preset::Paper, value_name = "NAME")]
    preset: Preset,
}

impl Add {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        // The seed of the index's own renders.
        let name = || format!("cannot use the index {}", self.index.display());
        let seed = Index::open(&self.index).with_context(name)?.catalogue().seed;
        let plan = self.plan.plan(seed)?;
        let more = if self.renders.is_empty() {
            Source::Plan(Box::new(plan.clone()))
        } else {
            let grasps = self.plan.grasps()?;
            let open = |folder| RenderSet::open(folder, &grasps);
            Source::Sets(self.renders.iter().map(PathBuf::as_path).map(open).collect::<Result<_, _>>()?)
        };
        let growth = Growth {
            indexes: vec![self.index.clone()],
            keep: self.segment.is_none(),
            without: Vec::new(),
            more: Some(more),
            plan,
        };
        let out = self.segment.as_ref().unwrap_or(&self.index);
        tell(out, &grow(&growth, out, global.progress())?, true)
    }
}

impl Remove {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let growth = Growth {
            indexes: vec![self.index.clone()],
            keep: true,
            without: self.hand_shape.clone(),
            more: None,
            plan: RenderPlan::preset(self.preset),
        };
        tell(&self.index, &grow(&growth, &self.index, global.progress())?, false)
    }
}

impl Compact {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let growth = Growth {
            indexes: self.indexes.clone(),
            keep: true,
            without: Vec::new(),
            more: None,
            plan: RenderPlan::preset(self.preset),
        };
        tell(&self.out, &grow(&growth, &self.out, global.progress())?, false)
    }
}
