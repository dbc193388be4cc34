//! `grasp-builder export`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::Index;
use grasp_program::{Global, output_file};
use grasp_terminal::text::{counted, shown};

use super::report::ENTRIES;
use crate::open_sound::open_sound;
use crate::same_file::is_same_file;
use crate::shard::{PartReader, is_part};
use crate::{export, interrupt};

/// Write what an index holds for other programs: its descriptors, its labels, or all of it as one
/// table.
///
/// `grasp-builder build --descriptors X.npy --labels Y.csv --descriptor NAME` makes an index of
/// them again, which finds the same neighbours. Its probabilities differ unless --held-out is
/// given: without, they are not calibrated.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("what").required(true).multiple(true)), after_help = "\
Examples:
  grasp-builder export grasp.idx --descriptors x.npy --labels y.csv
  grasp-builder build --descriptors x.npy --labels y.csv --descriptor default --out again.idx
  grasp-builder export parts/03-of-12.shard --parquet 03.parquet
  python -c 'import numpy; print(numpy.load(\"x.npy\", mmap_mode=\"r\").shape)'

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Export {
    /// The index; of a part that `shard` has made, --parquet can be written too.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// Write the descriptors here: 32-bit floating-point numbers in NumPy's format, one row per
    /// entry.
    #[arg(long, value_name = "X.npy", group = "what", value_parser = output_file())]
    descriptors: Option<PathBuf>,
    /// Write the labels here: a table, one line per entry.
    #[arg(long, value_name = "Y.csv", group = "what", value_parser = output_file())]
    labels: Option<PathBuf>,
    /// Write both as one Parquet file: one row per entry, columns named as in the labels, and the
    /// list `descriptor`.
    #[arg(long, value_name = "Z.parquet", group = "what", value_parser = output_file())]
    parquet: Option<PathBuf>,
}

/// Writes one thing that an index holds.
type Write = fn(&Index, &Path, &dyn Fn(u64)) -> anyhow::Result<()>;

impl Export {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let name = self.index.display();
        for out in [&self.descriptors, &self.labels, &self.parquet].into_iter().flatten() {
            if is_same_file(out, &self.index) {
                bail!("{} is the index itself: name another file to write", out.display());
            }
        }
        let outputs =
            [("--descriptors", &self.descriptors), ("--labels", &self.labels), ("--parquet", &self.parquet)];
        let named = outputs.iter().filter_map(|(option, out)| Some((*option, out.as_ref()?)));
        let named: Vec<(&str, &PathBuf)> = named.collect();
        for (at, (option, out)) in named.iter().enumerate() {
            if let Some((before, _)) = named[..at].iter().find(|(_, before)| is_same_file(before, out)) {
                bail!("{before} and {option} both name {}: name two files", out.display());
            }
        }
        if is_part(&self.index) {
            return self.part(global);
        }
        let index = open_sound(&self.index)?;
        let outputs: [(_, _, Write); 3] = [
            (&self.descriptors, "descriptors", export::descriptors),
            (&self.labels, "labels", export::labels),
            (&self.parquet, "descriptors and labels", export::index_as_parquet),
        ];
        for (out, what, write) in outputs {
            let Some(out) = out else { continue };
            let bar = global.progress().bar(index.len() as u64, "writing", "entries");
            let written = write(&index, out, &|done| bar.set_position(done));
            drop(bar);
            written.with_context(|| format!("the {what} of {name} were not written"))?;
            index.check_unchanged().with_context(|| format!("{} is not sound", out.display()))?;
            writeln!(
                std::io::stdout().lock(),
                "{}: {what} of {}",
                shown(out),
                counted(index.len(), ENTRIES)
            )?;
        }
        Ok(())
    }

    fn part(&self, global: &Global) -> anyhow::Result<()> {
        let name = self.index.display();
        let (Some(out), None, None) = (&self.parquet, &self.descriptors, &self.labels) else {
            bail!("{name} is a part of an index: --parquet alone can be written of it");
        };
        let spinner = global.progress().spinner("writing entries");
        let written =
            PartReader::open(&self.index).and_then(|part| export::part_as_parquet(part, out, &|_| ()));
        drop(spinner);
        let entries = written.with_context(|| format!("the entries of {name} were not written"))?;
        writeln!(std::io::stdout().lock(), "{}: {}", shown(out), counted(entries, ENTRIES))?;
        Ok(())
    }
}
