//! `grasp-builder shard`.

use std::io::Write as _;
use std::path::PathBuf;

use grasp_program::Global;
use grasp_terminal::text::{counted, shown};

use super::work::WorkOptions;
use crate::descriptor::shipped_network;
use crate::interrupt;
use crate::shard::{Share, shard};

/// Make one of N parts of an index, on one of many machines; `merge` makes the index of them.
///
/// Parts are made of the hand shapes in order (more exactly of their scenes; of render sets, the
/// pictures), and with the same options always have the same bytes. A part that is there already,
/// whole and of the same options, is left alone: a task that was stopped or lost can be run again
/// at any time, on any machine.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder shard --shard 3/12 --hands 120 --out parts
  for i in $(seq 12); do grasp-builder shard --shard $i/12 --hands 120 --out parts; done
  grasp-builder merge parts --out grasp.idx              the same bytes as by build --hands 120

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Shard {
    /// Which part, from 1, of how many.
    #[arg(long, value_name = "I/N")]
    shard: Share,
    /// The folder to write the part into.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    work: WorkOptions,
}

impl Shard {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let (source, recipe) = self.work.work()?;
        let (network, shipped) = (recipe.descriptor.network(), shipped_network().ok());
        if network.is_some_and(|network| Some(network) != shipped.as_ref()) {
            anyhow::bail!(
                "parts are described by the network of this program: leave out --network, or `build` in one piece"
            );
        }
        let report = shard(&source, &recipe, self.shard, &self.out, global.progress())?;
        let is = if report.was_there { " is up to date" } else { "" };
        let entries = counted(report.entries, ["entry", "entries"]);
        let without_hand = counted(report.without_hand, ["view shows", "views show"]);
        let mut stdout = std::io::stdout().lock();
        writeln!(stdout, "{}{is}: {entries}, {without_hand} no hand", shown(&report.path))?;
        Ok(())
    }
}
