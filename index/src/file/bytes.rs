//! The bytes of an index, mapped or in memory. The one place where a file is mapped.

use super::align::ALIGNMENT;
use super::error::{FileChanged, OpenError};
use super::fault::Registered;
use super::header::{self, Header};
use super::stamp::Stamp;
use crate::search::ReadAhead;
use memmap2::{Mmap, MmapMut};
use rkyv::util::AlignedVec;
use std::fs::File;
use std::io::{self, Read};
use std::marker::PhantomData;
use std::ops::Deref;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Files of at least this many bytes are assumed not to fit into memory.
const LARGE: usize = 2 << 30;

/// The whole of a file. Starts at a multiple of 64 bytes in memory, so that sections can be read in
/// place.
pub(crate) enum Bytes {
    Mapped(Mapping),
    Held(AlignedVec<{ ALIGNMENT as usize }>),
    /// In pages of memory that are no file's: the system says where there are not enough.
    Read(MmapMut),
}

/// A file that is mapped, and what it takes to notice that another program changes it.
pub(crate) struct Mapping {
    /// Above the map: forgotten before it is unmapped.
    registered: Registered,
    map: Mmap,
    stamp: Stamp,
    /// It has been noticed: what is changed once is never whole again.
    is_changed: AtomicBool,
}

impl std::fmt::Debug for Bytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let how = match self {
            Self::Mapped(_) => "mapped",
            Self::Held(_) | Self::Read(_) => "held",
        };
        write!(f, "{} bytes, {how}", self.len())
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(mapping) => &mapping.map,
            Self::Held(bytes) => bytes,
            Self::Read(bytes) => bytes,
        }
    }
}

impl Bytes {
    /// Maps a file read-only.
    pub(crate) fn map(path: &Path) -> Result<Self, OpenError> {
        let stamp = Stamp::new(open_regular(path)?)?;
        // An empty file cannot be mapped; the header's check says what is wrong with it.
        if stamp.length() == 0 {
            return Ok(Self::copy(&[]));
        }
        // SAFETY: the mapping is read-only and private to this value. What a map cannot promise is
        // that no other process changes or truncates the file meanwhile. Index files are never
        // changed in place: this crate writes a new file and renames it over the old one, whose
        // bytes live on as long as they are mapped (tested in tests/writing.rs). Every byte pattern
        // is valid for the plain numbers that are read from it, and the catalogue and texts are
        // copied before they are checked, so bytes changed by a stranger can give wrong answers,
        // but no undefined values: they are noticed by `check_unchanged`. A file truncated by a
        // stranger ends the process with SIGBUS, unless it is guarded (`super::fault`). Where
        // neither will do, use `Bytes::read`.
        let map = unsafe { Mmap::map(stamp.file())? };
        let registered = Registered::new(&map);
        Ok(Self::Mapped(Mapping { registered, map, stamp, is_changed: AtomicBool::new(false) }))
    }

    /// Reads a file into memory.
    pub(crate) fn read(path: &Path) -> Result<Self, OpenError> {
        let stamp = Stamp::new(open_regular(path)?)?;
        let mut file = stamp.file();
        let no_memory = || OpenError::NoMemory { length: stamp.length() };
        let length = usize::try_from(stamp.length()).map_err(|_| no_memory())?;
        // A length is only believed, and memory taken for it, where a header states it as well.
        let mut head = [0; header::LENGTH];
        let held = head.len().min(length);
        file.read_exact(&mut head[..held])?;
        Header::parse(&head[..held], length as u64)?;
        // Not from the allocator, which ends the program where memory is short.
        let mut bytes = MmapMut::map_anon(length).map_err(|_| no_memory())?;
        bytes[..held].copy_from_slice(&head[..held]);
        let filled = file.read_exact(&mut bytes[held..]);
        stamp.check()?;
        filled?;
        Ok(Self::Read(bytes))
    }

    /// Whether what was read of these bytes until now was of one file: that no other program has
    /// changed or truncated it.
    pub(crate) fn check_unchanged(&self) -> Result<(), FileChanged> {
        match self {
            Self::Held(_) | Self::Read(_) => Ok(()),
            Self::Mapped(mapping) => mapping.check_unchanged(),
        }
    }

    /// Copies bytes into pages of memory that are no file's.
    pub(crate) fn private_copy(bytes: &[u8]) -> io::Result<Self> {
        if bytes.is_empty() {
            return Ok(Self::copy(&[]));
        }
        let mut pages = MmapMut::map_anon(bytes.len())?;
        pages.copy_from_slice(bytes);
        Ok(Self::Read(pages))
    }

    /// Copies bytes that are in memory already, because those need not be aligned.
    pub(crate) fn copy(bytes: &[u8]) -> Self {
        let mut held = AlignedVec::with_capacity(bytes.len());
        held.extend_from_slice(bytes);
        Self::Held(held)
    }
}

impl ReadAhead for Bytes {
    /// Asks the operating system to read `part` of these bytes ahead: all of it at once and beside
    /// others, instead of page by page as it is touched. Of no effect besides time.
    fn will_need(&self, part: &[u8]) {
        #[cfg(unix)]
        if let Self::Mapped(Mapping { map, .. }) = self {
            let start = (part.as_ptr() as usize).checked_sub(map.as_ptr() as usize);
            if let Some(start) = start.filter(|start| start + part.len() <= map.len() && !part.is_empty()) {
                // A system that cannot do so reads page by page.
                let _ = map.advise_range(memmap2::Advice::WillNeed, start, part.len());
            }
        }
        #[cfg(not(unix))]
        let _ = part;
    }

    /// Tells the operating system that a large file will be read here and there: that it should not
    /// read on beyond each page that is touched. Of no effect besides time.
    ///
    /// Of 20 million entries (8.4 GB) in 1 GB of memory, on a disk set to read on by 8 MB, a search
    /// read 200 MB, of which it used 200 kB. A file that fits into memory is the sooner there if
    /// the system reads on.
    fn will_jump(&self) {
        #[cfg(unix)]
        if let Self::Mapped(Mapping { map, .. }) = self
            && map.len() >= LARGE
        {
            let _ = map.advise(memmap2::Advice::Random);
        }
    }

    /// Asks for `part` of a large file, which will be read next and from front to back, as
    /// [`Self::will_need`] does: it may have been told that it [`Self::will_jump`].
    fn will_pass(&self, part: &[u8]) {
        if self.len() >= LARGE {
            self.will_need(part);
        }
    }
}

impl Mapping {
    fn check_unchanged(&self) -> Result<(), FileChanged> {
        // A fault always comes with a length that has changed, unless the file has grown back
        // since, or the disk failed.
        let is_changed = self.is_changed.load(Ordering::Relaxed)
            || self.registered.has_faulted()
            || self.stamp.check().is_err();
        if is_changed {
            self.is_changed.store(true, Ordering::Relaxed);
            return Err(FileChanged);
        }
        Ok(())
    }
}

/// What a writer has written so far, to look at: mapped, or in its memory. The writer is borrowed
/// meanwhile.
pub(crate) enum Written<'a> {
    Mapped(Mmap, PhantomData<&'a mut File>),
    Held(&'a [u8]),
}

impl<'a> Written<'a> {
    /// Maps a file that this program alone writes, and that it writes through `file` alone: another
    /// handle of the same writer may sync and rename it.
    pub(crate) fn map(file: &'a mut File) -> io::Result<Self> {
        // An empty file cannot be mapped.
        if file.metadata()?.len() == 0 {
            return Ok(Self::Held(&[]));
        }
        // SAFETY: the mapping is read-only, and `file`, by which alone the file is written, is
        // borrowed for as long as the mapping lives. The file is the locked part of an index or has
        // no name, so another program changes it on purpose only. It is not registered with
        // `super::fault`: where such a program truncates it, the signal ends the process.
        let map = unsafe { Mmap::map(&*file)? };
        Ok(Self::Mapped(map, PhantomData))
    }

    #[cfg(unix)]
    fn advise(&self, advice: memmap2::Advice) {
        if let Self::Mapped(map, _) = self {
            // Where advice is unsupported, the result is the same.
            let _ = map.advise(advice);
        }
    }
}

impl ReadAhead for Written<'_> {
    /// What is in memory is there already, since it has just been written; the rest did not fit.
    fn will_jump(&self) {
        #[cfg(unix)]
        self.advise(memmap2::Advice::Random);
    }

    /// A writer's rows are read as a whole.
    fn will_need(&self, _: &[u8]) {}

    /// All of the file, by several threads at several places.
    fn will_pass(&self, _: &[u8]) {
        #[cfg(unix)]
        self.advise(memmap2::Advice::Sequential);
    }
}

impl Deref for Written<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map, _) => map,
            Self::Held(bytes) => bytes,
        }
    }
}

fn open_regular(path: &Path) -> Result<File, OpenError> {
    // Asked before opening: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(OpenError::Folder);
    }
    if !metadata.is_file() {
        return Err(OpenError::NotAFile);
    }
    Ok(File::open(path)?)
}
