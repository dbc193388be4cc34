//! `grasp-builder build`.

use std::io::Write as _;
use std::path::PathBuf;

use grasp_program::{Global, output_file};
use grasp_terminal::text::shown;

use super::report::print_report;
use super::work::WorkOptions;
use crate::indexing::{Source, build};
use crate::interrupt;

/// Build an index from render sets, straight from hand shapes, or from vectors that were described
/// elsewhere.
///
/// RENDERS are folders with a manifest.csv, as `grasp-builder render` or any other program wrote
/// them. Without RENDERS the views are rendered on the fly. An existing index at FILE gives what it
/// knows of the same pictures, and is replaced in one step when the new one is whole; a program
/// that has it mapped goes on undisturbed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder build --out grasp.idx                       the default: any hand, from any side
  grasp-builder build --preset paper --out paper.idx        the paper's 6 x 900 views of one hand
  grasp-builder build --hands 30 --rolls 12 --step 12 --out many.idx
  grasp-builder render --out rendered
  grasp-builder build rendered --out grasp.idx --descriptor paper
  grasp-builder build --descriptors x.npy --labels y.csv --out vectors.idx

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Build {
    /// The index to write.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx", value_parser = output_file())]
    out: PathBuf,
    #[command(flatten)]
    work: WorkOptions,
}

impl Build {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let (source, recipe) = self.work.work()?;
        let report = build(&source, &recipe, &self.out, global.progress())?;
        let pictures = !matches!(source, Source::Vectors(_));
        print_report(&self.out, &report, pictures)?;
        if report.written.is_some() {
            writeln!(std::io::stdout().lock(), "  seed {}", self.work.seed())?;
        }
        Ok(())
    }

    /// What is kept when the build is stopped, and how to build so that more is.
    pub(super) fn when_stopped(&self) -> String {
        let out = shown(&self.out);
        let left = if self.out.exists() { "is as it was" } else { "is not written" };
        format!(
            "nothing of this build is kept, and {out} {left}.\nBuilt in parts, finished parts are kept: run `grasp-builder shard \
             --shard I/12 --out parts` with the other options\nof this build for I = 1 to 12, and after Ctrl-C again for those \
             that are missing; then `grasp-builder merge parts --out {out}`"
        )
    }
}
