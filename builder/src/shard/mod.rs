//! One part of an index, made by one of many machines: `build`, up to where the hash is made.
//!
//! A [`Source`]'s pieces are split evenly and in order. What a build would hand to its index, a
//! shard writes to a file, a part, to the last bit; [`mod@crate::merge`] reads the parts in order
//! and does the rest of the build. So a merged index is, byte for byte, the one that a single
//! machine builds.

mod header;
mod part;
mod share;

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;
use grasp_terminal::Progress;

use crate::indexing::{Described, Known, Recipe, Source};
use crate::interrupt;

pub(crate) use header::Header;
pub(crate) use part::{HeldOutRows, PartReader, PartWriter, is_part};
pub(crate) use share::EXTENSION;
pub use share::{NotAShare, Share};

/// What making a part did.
#[derive(Debug)]
pub struct Report {
    /// The part.
    pub path: PathBuf,
    /// Entries in it.
    pub entries: u64,
    /// Pictures that show no hand and make no entry.
    pub without_hand: u64,
    /// Whether the part was there already, valid and of the same parameters.
    pub was_there: bool,
}

/// Makes a part of the index of `source` in the folder `out`, unless it is there.
///
/// # Errors
/// When a picture cannot be read or the part cannot be written; what was at its place before is
/// then as it was. [`Interrupted`](crate::interrupt::Interrupted) when the user asked to stop.
pub fn shard(
    source: &Source,
    recipe: &Recipe,
    share: Share,
    out: &Path,
    progress: Progress,
) -> anyhow::Result<Report> {
    std::fs::create_dir_all(out).with_context(|| format!("cannot create the folder {}", out.display()))?;
    let path = out.join(share.file_name());
    let pieces = source.pieces();
    if pieces < share.of as usize {
        bail!(
            "there are {pieces} scenes, pictures or rows, too few for {} parts: lower N in --shard I/N",
            share.of
        );
    }
    let range = share.of_pieces(pieces);
    let names = source.names()?;
    let header = Header {
        share,
        made_from: source.digest(range.clone())?,
        params: recipe.params(&names),
        origin: source.origin(recipe)?,
    };
    // Two workers that were given the same part do not mix: the second is refused while the first
    // is at work, and finds the part whole afterwards.
    let file = AtomicFile::create(&path)?;
    if let Some((entries, without_hand)) = part::holds(&path, &header) {
        return Ok(Report { path, entries, without_hand, was_there: true });
    }
    let held_out = match share.shard {
        1 => recipe.held_out_rows(&names)?.into(),
        _ => HeldOutRows::default(),
    };
    let cannot = || format!("cannot write {}", path.display());
    let mut writer = PartWriter::new(file, &header, &held_out).with_context(cannot)?;
    let (doing, unit) = source.work();
    let bar = progress.bar((source.len() / share.of as usize) as u64, doing, unit);
    let mut take = |batch: Vec<Described>| -> anyhow::Result<()> {
        bar.inc(batch.len() as u64);
        interrupt::check()?;
        batch
            .into_iter()
            .try_for_each(|described| writer.push(described.map(|(entry, _)| entry)).with_context(cannot))
    };
    source.describe(&names, recipe, &Known::nothing(), range, &mut take)?;
    drop(bar);
    let (entries, without_hand) = writer.finish().with_context(cannot)?;
    Ok(Report { path, entries, without_hand, was_there: false })
}

#[cfg(test)]
mod tests;
