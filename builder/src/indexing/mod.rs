//! From pictures to an index.
//!
//! A [`Source`] lists what to index, in a fixed order. Its pictures are described in parallel and
//! collected in that order, so that the file's bytes do not depend on the number of threads. What
//! an existing index at the same path holds of the very same pictures (`known`) is taken over
//! instead of being rendered and described again; the bytes are those of a build from nothing.

mod described;
mod gather;
mod inputs;
mod known;
mod labels;
mod names;
mod planned;
mod recipe;
mod report;
mod sets;
mod source;
mod vectors;

use std::path::Path;
use std::time::Instant;

use grasp_index::AtomicFile;
use grasp_terminal::Progress;

use crate::interrupt;

pub(crate) use described::Described;
pub(crate) use gather::Gathered;
pub(crate) use inputs::{KEY as INPUTS, OPTIONS, tool};
pub(crate) use known::Known;
pub(crate) use names::Names;
pub use recipe::Recipe;
pub use report::Report;
pub use sets::{RenderSet, SetError};
pub use source::Source;
pub use vectors::Vectors;

/// The side of the thumbnails that an index keeps for showing its neighbours, in pixels.
pub const THUMBNAIL_SIDE: u32 = 48;

/// Builds the index of `source` at `out`.
///
/// # Errors
/// When a picture cannot be read, `out` is a file that is no index, or the index cannot be written.
/// The file at `out` is then as it was before. [`Interrupted`](crate::interrupt::Interrupted) when
/// the user asked to stop.
pub fn build(source: &Source, recipe: &Recipe, out: &Path, progress: Progress) -> anyhow::Result<Report> {
    let started = Instant::now();
    // Locked before hours of work, not after them.
    let file = AtomicFile::create(out)?;
    let known = Known::at(out, recipe.descriptor.params(), recipe.thumbnail_side)?;
    let names = source.names()?;
    let origin = source.origin(recipe)?;
    let mut gathered = Gathered::new(file, recipe.params(&names), origin)?;
    let (doing, unit) = source.work();
    let bar = progress.bar(source.len() as u64, doing, unit);
    let mut take = |batch: Vec<Described>| -> anyhow::Result<()> {
        bar.inc(batch.len() as u64);
        interrupt::check()?;
        gathered.take(batch)
    };
    source.describe(&names, recipe, &known, 0..source.pieces(), &mut take)?;
    drop(bar);
    let report = gathered.finish(&known, || recipe.held_out_rows(&names), progress)?;
    Ok(Report { elapsed: started.elapsed(), ..report })
}
