//! Which index to use: the options that name it.

use std::ffi::OsString;
use std::path::PathBuf;

#[cfg(feature = "serve")]
use anyhow::bail;
use grasp_answer::index_file::{self, IndexFileError, default_path};
use grasp_index::{Index, Segments};
use grasp_terminal::error::message;
use tracing::warn;

/// The index to search.
#[derive(Debug, clap::Args)]
pub(super) struct IndexFile {
    /// The index; without it, what GRASP_INDEX names, else ./grasp.idx, else grasp/grasp.idx in
    /// the user's data folder (~/.local/share on Linux), else grasp.idx beside this program.
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
        named.map_or_else(default_path, PathBuf::from)
    }

    /// Opens an index that recognises pictures.
    pub(super) fn open_for_pictures(&self) -> Result<Index, IndexFileError> {
        index_file::open_for_pictures(&self.path(), self.no_mmap)
    }

    /// Whether what the index has said may be believed. To be asked after the work, and before
    /// anything of it is written.
    pub(super) fn check(&self, index: &Index) -> Result<(), IndexFileError> {
        index_file::check(&self.path(), index)
    }
}

/// What the service and the quiz ask.
#[cfg(feature = "serve")]
impl IndexFile {
    /// An index that recognises pictures, where one is named or lies at the default
    /// place; `None` is not an error otherwise.
    pub(super) fn open_if_there(&self) -> Result<Option<Index>, IndexFileError> {
        let is_named = self.index.as_ref().is_some_and(|name| !name.is_empty());
        if is_named || self.path().exists() { self.open_for_pictures().map(Some) } else { Ok(None) }
    }

    /// Whether the index is read into memory instead of being mapped.
    pub(super) fn is_read(&self) -> bool {
        self.no_mmap
    }

    /// Opens the index.
    pub(super) fn open(&self) -> Result<Index, IndexFileError> {
        index_file::open(&self.path(), self.no_mmap)
    }

    /// Rejects an own index where a service answers by its own.
    pub(super) fn refuse_beside_a_service(&self) -> anyhow::Result<()> {
        refuse_beside_a_service(self.index.as_slice(), self.no_mmap)
    }
}

/// Rejects indexes that an option names. What GRASP_INDEX names is for the other commands.
#[cfg(feature = "serve")]
fn refuse_beside_a_service(named: &[OsString], no_mmap: bool) -> anyhow::Result<()> {
    let by_variable = std::env::var_os("GRASP_INDEX");
    if named.iter().any(|name| by_variable.as_ref() != Some(name)) {
        bail!("a service answers by its own index: with --server, leave out --index");
    }
    if no_mmap {
        bail!("a service opens its index itself: with --server, leave out --no-mmap");
    }
    Ok(())
}

/// The indexes to search as one.
#[derive(Debug, clap::Args)]
pub(super) struct IndexFiles {
    /// The index; without it, what GRASP_INDEX names, else ./grasp.idx, else grasp/grasp.idx in
    /// the user's data folder (~/.local/share on Linux), else grasp.idx beside this program. May
    /// be repeated: the indexes are searched as one, their entries being numbered on in this
    /// order.
    #[arg(long, value_name = "FILE", env = "GRASP_INDEX", hide_env_values = true, value_parser = clap::value_parser!(OsString))]
    index: Vec<OsString>,
    /// Read the index into memory instead of mapping it, e.g. from a network file system.
    #[arg(long)]
    no_mmap: bool,
    /// Of several indexes, leave out those that cannot be opened, and say so, instead of failing.
    /// Entries are numbered without them.
    #[arg(long)]
    allow_missing: bool,
}

impl IndexFiles {
    /// Their paths, at least one.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let named: Vec<PathBuf> =
            self.index.iter().filter(|name| !name.is_empty()).map(PathBuf::from).collect();
        if named.is_empty() { vec![default_path()] } else { named }
    }

    /// Opens them all, or those that can be; returns how many there should be as well.
    pub(super) fn open(&self) -> anyhow::Result<(Segments, usize)> {
        let paths = self.paths();
        let mut indexes = Vec::with_capacity(paths.len());
        for path in &paths {
            match index_file::open(path, self.no_mmap) {
                Ok(index) => indexes.push(index),
                Err(error) if self.allow_missing && paths.len() > 1 => {
                    let error = anyhow::Error::from(error);
                    warn!(subject = env!("CARGO_PKG_NAME"), "left out: {}", message(error.chain()));
                }
                Err(error) => return Err(error.into()),
            }
        }
        if indexes.len() < paths.len() {
            let (searched, named) = (indexes.len(), paths.len());
            warn!(
                subject = env!("CARGO_PKG_NAME"),
                searched, named, "{searched} of {named} indexes are searched"
            );
        }
        Ok((Segments::new(indexes)?, paths.len()))
    }

    /// Rejects own indexes where a service answers by its own.
    #[cfg(feature = "serve")]
    pub(super) fn refuse_beside_a_service(&self) -> anyhow::Result<()> {
        refuse_beside_a_service(&self.index, self.no_mmap)
    }
}
