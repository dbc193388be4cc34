//! `grasp-builder merge`.

use std::path::PathBuf;

use super::Global;
use super::build::tell;
use crate::interrupt;
use crate::merge::merge;

/// Make an index of all its parts: byte for byte the one that a single `build` of the same options makes.
#[derive(Debug, clap::Args)]
pub(crate) struct Merge {
    /// The folder that `shard` has written all parts into.
    #[arg(value_name = "DIR")]
    parts: PathBuf,
    /// The index to write.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx")]
    out: PathBuf,
}

impl Merge {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let report = merge(&self.parts, &self.out, global.progress())?;
        tell(&self.out, &report, false)
    }
}
