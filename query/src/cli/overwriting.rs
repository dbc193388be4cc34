//! Outputs that are inputs as well.

use std::path::Path;

use anyhow::bail;

/// Rejects an output that is one of the inputs: writing it would destroy what it was made from.
pub(super) fn refuse_overwriting<'a>(
    out: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    let Ok(out_file) = out.canonicalize() else {
        return Ok(());
    };
    if inputs.into_iter().any(|input| input.canonicalize().is_ok_and(|input| input == out_file)) {
        bail!("{} is an input as well: name another file to write", out.display());
    }
    Ok(())
}
