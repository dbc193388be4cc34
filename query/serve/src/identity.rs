//! Which file lies at a path, told without reading all of it.

use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::path::Path;
use std::time::{Duration, SystemTime};

use xxhash_rust::xxh3::xxh3_64;

/// As many bytes as an index's header has; it holds hashes of the rest.
const HEADER: u64 = 64;

/// Changes whenever another file is put in the place of the first, and whenever it is written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    device: u64,
    inode: u64,
    length: u64,
    header: u64,
    modified: Option<SystemTime>,
}

impl Identity {
    /// The identity of the file at `path`.
    pub(super) fn of_file(path: &Path) -> io::Result<Self> {
        // Asked before opening: opening a pipe waits for its other end.
        let metadata = std::fs::metadata(path)?;
        if !metadata.is_file() {
            return Err(io::Error::other("it is no regular file"));
        }
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        let mut header = Vec::with_capacity(HEADER as usize);
        file.take(HEADER).read_to_end(&mut header)?;
        let (device, inode) = place(&metadata);
        let modified = metadata.modified().ok();
        Ok(Self { device, inode, length: metadata.len(), header: xxh3_64(&header), modified })
    }

    /// The file's length in bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Whether the file was written to within `time`; false where its time lies in the future.
    pub(super) fn was_written_within(&self, time: Duration) -> bool {
        self.modified
            .and_then(|modified| SystemTime::now().duration_since(modified).ok())
            .is_some_and(|age| age < time)
    }
}

#[cfg(unix)]
fn place(metadata: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt as _;
    (metadata.dev(), metadata.ino())
}

/// Elsewhere length, header and time must do.
#[cfg(not(unix))]
fn place(_: &Metadata) -> (u64, u64) {
    (0, 0)
}
