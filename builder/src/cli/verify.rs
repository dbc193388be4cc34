//! `grasp-builder verify`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context as _, bail};
use grasp_index::Index;
use grasp_terminal::text::{counted, shown};

/// Read every byte of an index and check it.
///
/// Opening an index checks its header, its catalogue and its network only, so that it takes no
/// time; this checks the rest: every section against its hash, and what the numbers in it refer to.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder verify grasp.idx

Exit status: 0 where it can be used, 2 where it cannot.")]
pub(crate) struct Verify {
    /// The index.
    #[arg(value_name = "FILE")]
    index: PathBuf,
}

impl Verify {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let name = self.index.display();
        let index = Index::open(&self.index).with_context(|| format!("{name} is no sound index"))?;
        let found = index.verify();
        index.check_unchanged().with_context(|| format!("{name} was not verified"))?;
        if found.is_sound() {
            writeln!(
                std::io::stdout().lock(),
                "{}: sound, {} checked",
                shown(&self.index),
                counted(found.bytes, ["byte", "bytes"])
            )?;
            return Ok(());
        }
        let problems: Vec<String> = found.problems.iter().map(ToString::to_string).collect();
        bail!("{name} is damaged:\n  {}", problems.join("\n  "))
    }
}
