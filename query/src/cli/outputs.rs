//! Outputs are looked at before the work that they are for: none is written over an input, and what
//! cannot be written is not found out at the end.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;

/// Rejects an output that is one of the inputs: writing it would destroy what it was made from.
pub(super) fn refuse_overwriting<'a>(
    out: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    refuse_overwriting_by_any([out], inputs)
}

/// The same of several outputs.
pub(super) fn refuse_overwriting_by_any<'a, 'b>(
    outs: impl IntoIterator<Item = &'b Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    // Only a file that exists can be written over.
    let mut outs = outs.into_iter().filter_map(|out| Some((out, out.canonicalize().ok()?))).peekable();
    if outs.peek().is_none() {
        return Ok(());
    }
    let inputs: HashSet<_> = inputs.into_iter().filter_map(|input| input.canonicalize().ok()).collect();
    if let Some((out, _)) = outs.find(|(_, file)| inputs.contains(file)) {
        bail!("{} is an input as well: name another file to write", out.display());
    }
    Ok(())
}

/// Rejects a file for results that is one of the inputs, or that cannot be written.
pub(super) fn check_file<'a>(out: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> anyhow::Result<()> {
    refuse_overwriting(out, inputs)?;
    // Dropped, it leaves nothing behind.
    Ok(AtomicFile::create(out).map(drop)?)
}

/// Makes a folder for results, which are the `files` in it; rejects it where one of these is an
/// input, or cannot be written.
pub(super) fn make_folder<'a>(
    folder: &Path,
    files: &[&str],
    inputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    let files: Vec<PathBuf> = files.iter().map(|name| folder.join(name)).collect();
    refuse_overwriting_by_any(files.iter().map(PathBuf::as_path), inputs)?;
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    files.iter().try_for_each(|file| check_file(file, []))
}
