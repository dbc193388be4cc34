//! The index that is served, and its replacement while requests are under way.
//!
//! A new index that is renamed to the path takes over without a gap, because the old file lives on
//! while it is mapped. One that is copied over the old one (`cp`, `scp`) destroys what is mapped. A
//! small index is therefore read into memory, and served on until the copy is whole. A large one is
//! lost: its requests are turned away, because what they have read may be of two files, until the
//! new file verifies.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use grasp_index::Index;

use super::identity::Identity;
use super::unusable::{IndexFault, UnusableIndex};

/// What a service does without its index.
pub(super) const LOST: &str =
    "has lost its index, whose file was overwritten or cut short in place, and answers when that is whole";

/// A file that was written to so lately may be written to again within the same step of the file
/// system's clock.
const SETTLED: Duration = Duration::from_millis(20);
/// A file that cannot be used and was written to so lately is taken to be on its way.
const ON_ITS_WAY: Duration = Duration::from_secs(1);

/// An index in service. Requests hold it until they are answered, also after another has taken its
/// place.
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
    /// Files of at most this many bytes are read into memory.
    most_read: u64,
    served: RwLock<Option<Arc<Served>>>,
    /// Held while a new index is opened: one at a time.
    last: Mutex<Last>,
    failures: RwLock<Failures>,
}

/// What the last look has seen.
#[derive(Debug, Default)]
struct Last {
    /// What lay at the path; `None` where that is to be opened whatever it is.
    found: Option<Result<Identity, std::io::ErrorKind>>,
    /// The generation whose loss has been reported.
    lost: u64,
}

/// What went wrong with replacements.
#[derive(Clone, Debug, Default)]
pub(super) struct Failures {
    /// How often a new file could not be used.
    pub(super) count: u64,
    /// What is wrong with the file that lies there now; `None` where it is the one that is served.
    pub(super) current: Option<Arc<UnusableIndex>>,
}

/// What a look at the path found.
#[derive(Debug)]
pub(super) enum Refresh {
    /// The file that was there before.
    Unchanged,
    /// Another one, which is served now, as this generation.
    Replaced(u64),
    /// One that cannot be used, or none.
    Failed(Arc<UnusableIndex>),
    /// One that is being written: worth another look soon.
    Incomplete,
    /// The file that is served has been overwritten or truncated. Reported once.
    Overwritten,
}

impl Served {
    /// Whether the file has been overwritten or truncated, so that what the index says may be
    /// wrong.
    pub(super) fn is_lost(&self) -> bool {
        self.index.check_unchanged().is_err()
    }
}

impl Current {
    /// Nothing is opened yet.
    pub(super) fn new(path: PathBuf, most_read: u64) -> Self {
        Self {
            path,
            most_read,
            served: RwLock::default(),
            last: Mutex::default(),
            failures: RwLock::default(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The index that was opened last, which may be lost; `None` before the first is open.
    pub(super) fn get(&self) -> Option<Arc<Served>> {
        // Only whole values are ever put behind this lock.
        self.served.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn failures(&self) -> Failures {
        self.failures.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether there was an index to answer by, and it is lost.
    pub(super) fn is_lost(&self) -> bool {
        self.get().is_some_and(|served| served.is_lost())
    }

    /// Looks at the path and, where another file lies there than the last time, or where `forced`,
    /// opens it, checks it and puts it in the place of the one that is served. What cannot be used
    /// changes nothing, and is tried again when it changes.
    pub(super) fn refresh(&self, forced: bool) -> Refresh {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let old = self.get();
        if let Some(old) = old.as_ref().filter(|old| old.generation > last.lost && old.is_lost()) {
            // Also where the same file is copied there again, it must be opened anew.
            *last = Last { found: None, lost: old.generation };
            return Refresh::Overwritten;
        }
        // Before opening: where the file is replaced in between, the next look finds yet another
        // one.
        let found = Identity::of_file(&self.path);
        let seen = found.as_ref().map(|identity| *identity).map_err(std::io::Error::kind);
        if !forced && last.found == Some(seen) {
            return Refresh::Unchanged;
        }
        let is_young =
            |time| old.is_some() && !forced && seen.is_ok_and(|identity| identity.was_written_within(time));
        if is_young(SETTLED) {
            return Refresh::Incomplete;
        }
        let opened = found.map_err(IndexFault::from).and_then(|identity| self.open(&identity));
        // What could not be used may be another file already than the one that was found.
        let has_changed = || old.is_some() && Identity::of_file(&self.path).ok() != seen.ok();
        if opened.is_err() && (is_young(ON_ITS_WAY) || has_changed()) {
            return Refresh::Incomplete;
        }
        last.found = Some(seen);
        let mut failures = self.failures.write().unwrap_or_else(PoisonError::into_inner);
        match opened {
            Ok(index) => {
                failures.current = None;
                Refresh::Replaced(self.put(index))
            }
            Err(fault) => {
                let why = self.unusable(fault);
                failures.count += 1;
                failures.current = Some(Arc::clone(&why));
                Refresh::Failed(why)
            }
        }
    }

    /// What is wrong with what lies at the path.
    pub(super) fn unusable(&self, fault: IndexFault) -> Arc<UnusableIndex> {
        Arc::new(UnusableIndex { path: self.path.clone(), fault })
    }

    fn put(&self, index: Index) -> u64 {
        let opened_at = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let mut served = self.served.write().unwrap_or_else(PoisonError::into_inner);
        let generation = served.as_ref().map_or(0, |old| old.generation) + 1;
        *served = Some(Arc::new(Served { index, generation, opened_at }));
        generation
    }

    /// Opens what lies at the path. The first index is served as soon as it is open; one that
    /// replaces another is read through first, so that nothing damaged takes the place of something
    /// sound, and no request waits for the disk.
    fn open(&self, identity: &Identity) -> Result<Index, IndexFault> {
        let is_read = identity.length() <= self.most_read;
        let index = if is_read { Index::read(&self.path)? } else { Index::open(&self.path)? };
        let Some(old) = self.get() else {
            return Ok(index);
        };
        if let Some(problem) = index.verify().problems.into_iter().next() {
            return Err(problem.into());
        }
        index.check_unchanged()?;
        if old.index.check_recognises().is_ok() {
            index.check_recognises().map_err(IndexFault::RecognisesNothing)?;
        }
        Ok(index)
    }
}
