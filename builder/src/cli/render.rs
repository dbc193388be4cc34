//! `grasp-builder render`.

use std::io::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context as _;
use grasp_renders::Preset;
use grasp_renders::render_set::{RenderSetError, write_set};

use grasp_program::Global;
use grasp_terminal::text::{counted, shown};
use tracing::warn;

use super::plan::PlanOptions;
use super::seed::DEFAULT_SEED;
use crate::interrupt::{self, Interrupted};

/// Render views of grasping hands into a folder: a render set.
///
/// Pictures lie in folders by hand shape and grasp, 48 x 48 grey, the hand on black; manifest.csv
/// labels them. Pictures that are there already and were made of the same parameters are kept, so
/// that a stopped run goes on where it was.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder render --out rendered                       the paper's 6 x 900 views of one hand
  grasp-builder render --out many --hands 10 --step 12      fewer views of more hands
  grasp-builder render --out one --hand-shape slender --stage close --stage grasp

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Render {
    /// The render set's folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    plan: PlanOptions,
}

impl Render {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let plan = self.plan.clone().otherwise(Preset::Paper).plan(self.seed)?;
        let started = Instant::now();
        let bar = global.progress().bar(plan.renders() as u64, "rendering", "views");
        let written =
            write_set(&self.out, &plan, &|done, _| bar.set_position(done as u64), interrupt::flag());
        drop(bar);
        let summary = match written {
            Err(RenderSetError::Cancelled { .. }) => return Err(Interrupted.into()),
            other => other.with_context(|| format!("{} is not complete", self.out.display()))?,
        };
        writeln!(
            std::io::stdout().lock(),
            "{}: {}, {} made and {} kept, in {:.2} s\n  seed {}",
            shown(&summary.manifest),
            counted(summary.rendered + summary.kept, ["render", "renders"]),
            summary.rendered,
            summary.kept,
            started.elapsed().as_secs_f64(),
            self.seed
        )?;
        if summary.unlisted > 0 {
            let renders = counted(summary.unlisted, ["other render stays", "other renders stay"]);
            warn!("{renders} in {}, and the manifest lists them no more", shown(&self.out));
        }
        Ok(())
    }
}
