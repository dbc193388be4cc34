//! Indexes that others are made of.

use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::Index;

/// Opens an index and reads all of it: what is flipped in it would be sealed as sound in what is
/// made of it.
///
/// # Errors
/// Where it cannot be opened, or is damaged.
pub(crate) fn open_sound(path: &Path) -> anyhow::Result<Index> {
    let index = Index::open(path).with_context(|| format!("cannot use the index {}", path.display()))?;
    match index.verify().problems.first() {
        Some(problem) => bail!("{} is damaged: {problem}", path.display()),
        None => Ok(index),
    }
}
