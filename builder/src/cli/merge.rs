//! `grasp-builder merge`.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use grasp_index::{AtomicFile, WriteError};
use grasp_program::{Global, output_file};

use super::report::print_report;
use super::split::{parse_count, print_segments};
use crate::interrupt;
use crate::merge::merge;
use crate::open_sound::open_sound;
use crate::split::{Place, split_into};

/// Make an index of all its parts: byte for byte the one that a single `build` of the same options
/// makes.
///
/// With --segments, that index is written as several, as `split` does: searched as one, they answer
/// exactly as it does.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder merge parts --out grasp.idx
  grasp-builder merge parts --segments 4 --out-dir segments

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Merge {
    /// The folder that `shard` has written all parts into.
    #[arg(value_name = "DIR")]
    parts: PathBuf,
    /// The index to write.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx", value_parser = output_file())]
    out: PathBuf,
    /// Write K segments instead: whole hand shapes in each, where there are as many, in order.
    #[arg(long, value_name = "K", value_parser = parse_count, requires = "out_dir", conflicts_with = "out")]
    segments: Option<u32>,
    /// The folder to write them into, as 1-of-K.idx and so on; the whole index lies there
    /// meanwhile.
    #[arg(long, value_name = "DIR", requires = "segments")]
    out_dir: Option<PathBuf>,
}

/// The index between merging and splitting. What is left of a run that was killed is an index: the
/// next one goes on from it if it is made of the same parts, and replaces it otherwise.
const WHOLE: &str = ".whole.idx";

/// Removes the file when it has served, however that ends.
struct Whole(PathBuf);

impl Drop for Whole {
    fn drop(&mut self) {
        // Nothing can be done about a failure here.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Locks the folder against other runs, until what is returned is dropped: the index in it is the
/// same for all, and a run that ends removes it.
fn alone(folder: &Path) -> anyhow::Result<AtomicFile> {
    // No such file is ever put in place; a part of one that was killed is taken over.
    AtomicFile::create(&folder.join(".whole")).map_err(|error| match error {
        WriteError::Locked { .. } => anyhow!(
            "another `merge --segments` is writing into {}: wait for it to end, or name another folder",
            folder.display()
        ),
        other => other.into(),
    })
}

impl Merge {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        if let Some((count, folder)) = self.segments.zip(self.out_dir.as_deref()) {
            return self.run_segments(count, folder, global);
        }
        let report = merge(&self.parts, &self.out, global.progress())?;
        print_report(&self.out, &report, false)
    }

    fn run_segments(&self, count: u32, folder: &Path, global: &Global) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        let _alone = alone(folder)?;
        // Before the work, and before the index takes the room of what was left there.
        let place = Place::new(folder, count)?;
        let path = folder.join(WHOLE);
        let report = merge(&self.parts, &path, global.progress())?;
        // Only now is it this run's: before, it may be what another has left.
        let whole = Whole(path);
        let segments = split_into(place, &whole.0, &open_sound(&whole.0)?, global.progress())?;
        drop(whole);
        print_report(folder, &report, false)?;
        print_segments(&segments)
    }
}
