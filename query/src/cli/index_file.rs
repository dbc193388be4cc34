//! Which index to use, and opening it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::Index;

/// Where an index is looked for when neither an option nor the environment names one.
const DEFAULT: &str = "grasp.idx";

/// The index to search.
#[derive(Debug, clap::Args)]
pub(super) struct IndexFile {
    /// The index; without it, what GRASP_INDEX names, else ./grasp.idx.
    #[arg(long, value_name = "FILE", env = "GRASP_INDEX", hide_env_values = true, value_parser = clap::value_parser!(OsString))]
    index: Option<OsString>,
    /// Read the index into memory instead of mapping it, e.g. from a network file system.
    #[arg(long)]
    no_mmap: bool,
}

impl IndexFile {
    /// The file's path.
    pub(super) fn path(&self) -> PathBuf {
        // `GRASP_INDEX= grasp-query ...` is how a shell unsets a variable for one command.
        let named = self.index.as_ref().filter(|name| !name.is_empty());
        named.map_or_else(|| DEFAULT.into(), PathBuf::from)
    }

    /// Opens an index that can tell what a picture shows.
    pub(super) fn open_for_pictures(&self) -> anyhow::Result<Index> {
        open_for_pictures(&self.path(), self.no_mmap)
    }

    /// The same where one is named or lies at the usual place; none is no error then.
    pub(super) fn open_if_there(&self) -> anyhow::Result<Option<Index>> {
        let is_named = self.index.as_ref().is_some_and(|name| !name.is_empty());
        if is_named || self.path().exists() { self.open_for_pictures().map(Some) } else { Ok(None) }
    }

    /// Whether the index is read into memory instead of being mapped.
    pub(super) fn is_read(&self) -> bool {
        self.no_mmap
    }

    pub(super) fn open(&self) -> anyhow::Result<Index> {
        open(&self.path(), self.no_mmap)
    }
}

/// Opens an index at a path, one that can tell what a picture shows.
pub(super) fn open_for_pictures(path: &Path, no_mmap: bool) -> anyhow::Result<Index> {
    let index = open(path, no_mmap)?;
    index.check_recognises().with_context(|| format!("cannot use the index {}", path.display()))?;
    Ok(index)
}

fn open(path: &Path, no_mmap: bool) -> anyhow::Result<Index> {
    if !path.exists() {
        bail!(
            "no index at {}: build one with `grasp-builder build --out grasp.idx`, or name one with --index or GRASP_INDEX",
            path.display()
        );
    }
    let opened = if no_mmap { Index::read(path) } else { Index::open(path) };
    opened.with_context(|| format!("cannot use the index {}", path.display()))
}
