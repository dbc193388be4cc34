//! The index that is served, and its replacement while requests are under way.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, bail};
use grasp_index::Index;

use super::identity::Identity;

/// An index in service. Requests hold it until they are answered, also after another has taken its place.
#[derive(Debug)]
pub(super) struct Served {
    pub(super) index: Index,
    /// 1 for the first index that was served, one more with each replacement.
    pub(super) generation: u64,
    /// Seconds since 1970.
    pub(super) opened_at: u64,
}

/// Where the index comes from, and which one is served.
#[derive(Debug)]
pub(super) struct Current {
    path: PathBuf,
    no_mmap: bool,
    served: RwLock<Option<Arc<Served>>>,
    /// What was found at the path when it was last looked at. Held while a new index is opened: one at a time.
    last: Mutex<Option<Result<Identity, std::io::ErrorKind>>>,
    trouble: RwLock<Trouble>,
}

/// What went wrong with replacements.
#[derive(Clone, Debug, Default)]
pub(super) struct Trouble {
    /// How often a new file could not be used.
    pub(super) failures: u64,
    /// What is wrong with the file that lies there now; `None` where it is the one that is served.
    pub(super) now: Option<String>,
}

/// What a look at the path found.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Looked {
    /// The file that was there before.
    Unchanged,
    /// Another one, which is served now, as this generation.
    Replaced(u64),
    /// One that cannot be used, or none.
    Failed(String),
}

impl Current {
    /// Nothing is opened yet.
    pub(super) fn new(path: PathBuf, no_mmap: bool) -> Self {
        Self { path, no_mmap, served: RwLock::default(), last: Mutex::default(), trouble: RwLock::default() }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The index to answer by; `None` before the first is open.
    pub(super) fn get(&self) -> Option<Arc<Served>> {
        // Only whole values are ever put behind this lock.
        self.served.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn trouble(&self) -> Trouble {
        self.trouble.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Looks at the path and, where another file lies there than the last time, or where `forced`, opens it, checks it and
    /// puts it in the place of the one that is served. What cannot be used changes nothing, and is tried again when it changes.
    pub(super) fn look(&self, forced: bool) -> Looked {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        // Before opening: where the file is replaced in between, the next look finds yet another one.
        let found = Identity::of(&self.path);
        let seen = found.as_ref().map(|identity| *identity).map_err(std::io::Error::kind);
        if !forced && *last == Some(seen) {
            return Looked::Unchanged;
        }
        *last = Some(seen);
        let opened = found.map_err(anyhow::Error::from).and_then(|_| self.open());
        let mut trouble = self.trouble.write().unwrap_or_else(PoisonError::into_inner);
        match opened {
            Ok(index) => {
                trouble.now = None;
                Looked::Replaced(self.put(index))
            }
            Err(error) => {
                let message = format!("cannot use the index {}: {error:#}", self.path.display());
                trouble.failures += 1;
                trouble.now = Some(message.clone());
                Looked::Failed(message)
            }
        }
    }

    fn put(&self, index: Index) -> u64 {
        let opened_at = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let mut served = self.served.write().unwrap_or_else(PoisonError::into_inner);
        let generation = served.as_ref().map_or(0, |old| old.generation) + 1;
        *served = Some(Arc::new(Served { index, generation, opened_at }));
        generation
    }

    /// Opens what lies at the path. The first index is served as soon as it is mapped; one that replaces another is
    /// read through first, so that nothing damaged takes the place of something sound, and no request waits for the disk.
    fn open(&self) -> anyhow::Result<Index> {
        let index = if self.no_mmap { Index::read(&self.path)? } else { Index::open(&self.path)? };
        let Some(old) = self.get() else {
            return Ok(index);
        };
        if let Some(problem) = index.verify().problems.first() {
            bail!("{problem}");
        }
        if old.index.check_recognises().is_ok() {
            index.check_recognises().context("the index that is served can tell what pictures show")?;
        }
        Ok(index)
    }
}
