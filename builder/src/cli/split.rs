//! `grasp-builder split`, and what `merge --segments` shares with it.

use std::io::Write as _;
use std::path::PathBuf;

use grasp_program::Global;
use grasp_terminal::text::shown;

use crate::interrupt;
use crate::split::{Segment, split};

/// Write an index as several, for a machine each or because one would be too large a file.
///
/// Segments hold whole hand shapes, where there are as many, in order, and share what was learned
/// from all entries: searched as one, with all of them named in order, they answer exactly as the
/// index does, at any effort.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder split grasp.idx --segments 4 --out-dir segments
  grasp-builder queries --out q.npy
  grasp-query search q.npy $(printf -- '--index %s ' segments/*-of-4.idx) --out ids.npy

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Split {
    /// The index, which stays.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// How many segments.
    #[arg(long, value_name = "K", value_parser = parse_count)]
    segments: u32,
    /// The folder to write them into, as 1-of-K.idx and so on.
    #[arg(long, value_name = "DIR")]
    out_dir: PathBuf,
}

/// A number of segments.
pub(super) fn parse_count(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|count| (1..=10_000).contains(count));
    count.ok_or_else(|| "an integer from 1 to 10,000 is needed".into())
}

impl Split {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        print_segments(&split(&self.index, self.segments, &self.out_dir, global.progress())?)
    }
}

/// Prints for a person what was written.
pub(super) fn print_segments(segments: &[Segment]) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    for Segment { path, entries, bytes } in segments {
        let (path, last) = (shown(path), entries.end.saturating_sub(1));
        writeln!(stdout, "{path}: entries {} to {last}, {:.1} MB", entries.start, *bytes as f64 / 1e6)?;
    }
    Ok(())
}
