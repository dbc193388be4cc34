//! No output is written over an input.

use std::collections::HashSet;
use std::path::Path;

use anyhow::bail;

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
