//! Which index to use, and opening it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use etcetera::base_strategy::{BaseStrategy as _, choose_native_strategy};
use grasp_index::{Index, Segments};
use grasp_terminal::error::message;
use tracing::warn;

/// What an index is called when neither an option nor the environment names one.
const DEFAULT: &str = "grasp.idx";
/// The folder that it has among a user's data.
const FOLDER: &str = "grasp";

/// Where it lies: in the working directory, among the user's data
/// (`$XDG_DATA_HOME/grasp/grasp.idx` on Linux), or beside this program, whichever is there first;
/// where none is, the first is where one is missed.
fn default_path() -> PathBuf {
    let program = std::env::current_exe().ok().map(|program| program.with_file_name(DEFAULT));
    let places = [Some(PathBuf::from(DEFAULT)), users_path(), program];
    places.into_iter().flatten().find(|path| path.exists()).unwrap_or_else(|| DEFAULT.into())
}

/// The index among the user's data, whether it is there or not; `None` for who has no home.
fn users_path() -> Option<PathBuf> {
    let folders = choose_native_strategy().ok();
    folders.map(|folders| folders.data_dir().join(FOLDER).join(DEFAULT))
}

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

    /// Opens an index that can tell what a picture shows.
    pub(super) fn open_for_pictures(&self) -> anyhow::Result<Index> {
        open_for_pictures(&self.path(), self.no_mmap)
    }

    /// Whether what the index has said may be believed. To be asked after the work, and before
    /// anything of it is written.
    pub(super) fn check(&self, index: &Index) -> anyhow::Result<()> {
        check(&self.path(), index)
    }
}

/// What the service and the quiz ask.
#[cfg(feature = "serve")]
impl IndexFile {
    /// An index that can tell what a picture shows, where one is named or lies at the default
    /// place; `None` is not an error otherwise.
    pub(super) fn open_if_there(&self) -> anyhow::Result<Option<Index>> {
        let is_named = self.index.as_ref().is_some_and(|name| !name.is_empty());
        if is_named || self.path().exists() { self.open_for_pictures().map(Some) } else { Ok(None) }
    }

    /// Whether the index is read into memory instead of being mapped.
    pub(super) fn is_read(&self) -> bool {
        self.no_mmap
    }

    /// Opens the index.
    pub(super) fn open(&self) -> anyhow::Result<Index> {
        open(&self.path(), self.no_mmap)
    }
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
            match open(path, self.no_mmap) {
                Ok(index) => indexes.push(index),
                Err(error) if self.allow_missing && paths.len() > 1 => {
                    warn!(subject = env!("CARGO_PKG_NAME"), "left out: {}", message(error.chain()));
                }
                Err(error) => return Err(error),
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
}

/// Opens an index at a path, one that can tell what a picture shows.
pub(super) fn open_for_pictures(path: &Path, no_mmap: bool) -> anyhow::Result<Index> {
    let index = open(path, no_mmap)?;
    index.check_recognises().with_context(|| format!("cannot use the index {}", path.display()))?;
    Ok(index)
}

/// [`IndexFile::check`] of an index at a path.
pub(super) fn check(path: &Path, index: &Index) -> anyhow::Result<()> {
    index.check_unchanged().with_context(|| format!("cannot use the index {}", path.display()))
}

fn open(path: &Path, no_mmap: bool) -> anyhow::Result<Index> {
    if !path.exists() {
        let users = users_path().unwrap_or_else(|| DEFAULT.into());
        bail!(
            "no index at {}: put a release's {DEFAULT} at {}, build one with `grasp-builder build --out grasp.idx`, or name one with --index or GRASP_INDEX",
            path.display(),
            users.display()
        );
    }
    let opened = if no_mmap { Index::read(path) } else { Index::open(path) };
    opened.with_context(|| format!("cannot use the index {}", path.display()))
}
