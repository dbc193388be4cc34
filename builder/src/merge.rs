//! From parts to an index: the second half of a build whose first half many machines have done.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;
use grasp_terminal::Progress;

use crate::indexing::{Gathered, Known, Report};
use crate::interrupt;
use crate::shard::{EXTENSION, HeldOutRows, PartReader};

/// Entries that are handed on at a time.
const ENTRIES_AT_ONCE: usize = 1 << 10;
/// Missing parts that a message names.
const NAMED: usize = 10;

/// Merges all parts in `folder` into the index `out`: the bytes are those of a single build.
///
/// # Errors
/// When a part is missing, damaged, or a part of something else, or the index cannot be written;
/// the file at `out` is then as it was. [`Interrupted`](crate::interrupt::Interrupted) when the
/// user asked to stop.
pub fn merge(folder: &Path, out: &Path, progress: Progress) -> anyhow::Result<Report> {
    let started = Instant::now();
    let parts = parts(folder)?;
    let Some((first_path, others)) = parts.split_first() else {
        bail!("there are no parts in {}: make them with `grasp-builder shard`", folder.display());
    };
    // Opened one after the other: there may be more parts than files that may be open.
    let header = |path: &Path| {
        PartReader::open(path).with_context(|| useless(path)).map(|reader| reader.header().clone())
    };
    let first = header(first_path)?;
    let mut by_shard = BTreeMap::from([(first.share.shard, first_path)]);
    for path in others {
        let header = header(path)?;
        if !first.goes_with(&header) {
            bail!(
                "{} and {} are parts of different indexes: run `grasp-builder shard` for one of them again with the options of the other, or put them into folders of their own",
                first_path.display(),
                path.display()
            );
        }
        if let Some(other) = by_shard.insert(header.share.shard, path) {
            bail!("{} and {} are the same part: remove one", other.display(), path.display());
        }
    }
    let missing: Vec<String> = (1..=first.share.of)
        .filter(|shard| !by_shard.contains_key(shard))
        .take(NAMED + 1)
        .map(|shard| shard.to_string())
        .collect();
    if !missing.is_empty() {
        let more = if missing.len() > NAMED { ", ..." } else { "" };
        bail!(
            "{} has {} of {} parts; missing: {}{more}: run `grasp-builder shard --shard I/{}` for these",
            folder.display(),
            by_shard.len(),
            first.share.of,
            missing.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", "),
            first.share.of
        );
    }
    let file = AtomicFile::create(out)?;
    let known = Known::at(out, &first.params.descriptor, first.params.thumbnail_side)?;
    let mut gathered = Gathered::new(file, first.params.clone(), first.origin.clone())?;
    let mut held_out = HeldOutRows::default();
    let bar = progress.bar(u64::from(first.share.of), "merging", "parts");
    for path in by_shard.values() {
        let rows = take(path, &mut gathered)?;
        if !rows.descriptors.is_empty() {
            held_out = rows;
        }
        bar.inc(1);
    }
    drop(bar);
    let report = gathered.finish(&known, || Ok((held_out.descriptors, held_out.classes)), progress)?;
    Ok(Report { elapsed: started.elapsed(), ..report })
}

/// Takes in the entries of a part, and gives what it holds out.
fn take(path: &Path, gathered: &mut Gathered) -> anyhow::Result<HeldOutRows> {
    let mut part = PartReader::open(path).with_context(|| useless(path))?;
    let mut batch = Vec::with_capacity(ENTRIES_AT_ONCE);
    loop {
        match part.next().with_context(|| useless(path))? {
            Ok(entry) => batch.push(Some((entry, false))),
            Err(without_hand) => {
                gathered.take(batch)?;
                gathered.add_without_hand(without_hand);
                return Ok(part.take_held_out());
            }
        }
        if batch.len() == ENTRIES_AT_ONCE {
            interrupt::check()?;
            gathered.take(std::mem::take(&mut batch))?;
        }
    }
}

/// The parts in a folder. The hidden files of parts that are being written are none.
fn parts(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let cannot = || format!("cannot read the folder {}", folder.display());
    let mut parts = Vec::new();
    for entry in folder.read_dir().with_context(cannot)? {
        let path = entry.with_context(cannot)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !is_hidden && path.extension().is_some_and(|extension| extension == EXTENSION) {
            parts.push(path);
        }
    }
    parts.sort();
    Ok(parts)
}

fn useless(path: &Path) -> String {
    format!("the part {} cannot be used: run `grasp-builder shard` for it again", path.display())
}
