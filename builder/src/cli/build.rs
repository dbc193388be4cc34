//! `grasp-builder build`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context as _, bail};
use grasp_index::{DescriptorParams, HashInfo, HashParams};

use super::Global;
use super::plan::PlanOptions;
use crate::build::{Recipe, RenderSet, Source, THUMBNAIL_SIDE, build};
use crate::interrupt;

/// Build an index from render sets, or straight from hand shapes.
///
/// RENDERS are folders with a manifest.csv, as `grasp-builder render` or any other program wrote them. Without RENDERS the
/// views are rendered on the fly. An existing index at FILE gives what it knows of the same pictures, and is replaced in
/// one step when the new one is whole; a program that has it mapped goes on undisturbed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder build --out grasp.idx
  grasp-builder build --hands 30 --rolls 12 --step 12 --out many.idx
  grasp-builder build renders blender-renders --out grasp.idx --descriptor paper")]
pub(crate) struct Build {
    /// Render sets to index; none renders on the fly.
    #[arg(value_name = "RENDERS", conflicts_with_all = ["preset", "hands", "hand_shape", "stage", "step", "elevations", "rolls", "distance", "forearm", "light_variation", "distance_variation"])]
    renders: Vec<PathBuf>,
    /// The index to write.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx")]
    out: PathBuf,
    /// What all randomness comes from.
    #[arg(long, default_value_t = 7, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    index: IndexOptions,
    #[command(flatten)]
    plan: PlanOptions,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What to make of it")]
struct IndexOptions {
    /// How hand images are described: `default`, or `paper` for the paper's own form.
    #[arg(long, default_value = "default", value_name = "NAME", value_parser = ["default", "paper"])]
    descriptor: String,
    /// How entries are hashed into buckets: `random` hyperplanes as in the paper.
    #[arg(long, default_value = "random", value_name = "NAME", value_parser = ["random"])]
    hash: String,
    /// Hash tables (the paper's T); by default learned from the data, together with --planes.
    #[arg(long, value_name = "T", requires = "planes", value_parser = clap::value_parser!(u32).range(1..=1024))]
    tables: Option<u32>,
    /// Hyperplanes a table (the paper's K).
    #[arg(long, value_name = "K", requires = "tables", value_parser = clap::value_parser!(u32).range(1..=64))]
    planes: Option<u32>,
    /// Buckets a table (the paper's H), for --tables and --planes.
    #[arg(long, value_name = "H", default_value_t = 4096, requires = "tables", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    buckets: u32,
    /// Side of the pictures that the index keeps for showing neighbours, in pixels; 0 keeps none.
    #[arg(long, value_name = "PIXELS", default_value_t = THUMBNAIL_SIDE, value_parser = clap::value_parser!(u32).range(0..=1024))]
    thumbnails: u32,
}

impl IndexOptions {
    fn recipe(&self, seed: u64) -> anyhow::Result<Recipe> {
        let descriptor = DescriptorParams::by_name(&self.descriptor)
            .with_context(|| format!("there is no descriptor named {}", self.descriptor))?;
        let hash = match (self.planes, self.tables) {
            (Some(k), Some(t)) => HashParams::Fixed { k, t, buckets: self.buckets },
            _ => HashParams::Auto,
        };
        Ok(Recipe { descriptor, hash, thumbnail_side: self.thumbnails, seed })
    }
}

impl Build {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let recipe = self.index.recipe(self.seed)?;
        let source = if self.renders.is_empty() {
            Source::Plan(Box::new(self.plan.plan(self.seed)?))
        } else {
            let grasps = self.plan.grasps()?;
            Source::Sets(
                self.renders
                    .iter()
                    .map(|folder| RenderSet::open(folder, &grasps))
                    .collect::<Result<_, _>>()?,
            )
        };
        if source.is_empty() {
            bail!("the render sets hold no picture");
        }
        let report = build(&source, &recipe, &self.out, global.progress())?;

        let mut stdout = std::io::stdout().lock();
        let (out, seconds) = (self.out.display(), report.elapsed.as_secs_f64());
        let Some(summary) = &report.written else {
            writeln!(stdout, "{out} is up to date: {} entries, checked in {seconds:.2} s", report.entries)?;
            return Ok(());
        };
        writeln!(
            stdout,
            "{out}: {} entries, {:.1} MB, in {seconds:.2} s ({} reused, {} described)",
            summary.entries,
            summary.bytes as f64 / 1e6,
            report.reused,
            report.entries - report.reused,
        )?;
        if report.without_hand > 0 {
            writeln!(stdout, "  {} views show no hand and were left out", report.without_hand)?;
        }
        if let HashInfo::Random(hash) = summary.hash {
            writeln!(
                stdout,
                "  hash: T = {} tables of K = {} hyperplanes; on {} held-out, disturbed entries a search finds a \
                 neighbour within {:.0} % of the nearest in {:.1} % of cases and measures {:.0} % of the database",
                hash.tables,
                hash.planes,
                summary.measured.queries,
                summary.measured.eps * 100.0,
                summary.measured.eps_success * 100.0,
                summary.measured.share_of_database * 100.0,
            )?;
        }
        writeln!(stdout, "  seed {}", self.seed)?;
        Ok(())
    }
}
