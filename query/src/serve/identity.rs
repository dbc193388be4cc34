//! Which file lies at a path, told without reading all of it.

use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::path::Path;

use xxhash_rust::xxh3::xxh3_64;

/// As many bytes as an index's header has; it holds hashes of the rest.
const HEADER: u64 = 64;

/// Changes whenever another file is put in the place of the first, and whenever its length or its header changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    device: u64,
    inode: u64,
    length: u64,
    header: u64,
}

impl Identity {
    /// The identity of the file at `path`.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
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
        Ok(Self { device, inode, length: metadata.len(), header: xxh3_64(&header) })
    }
}

#[cfg(unix)]
fn place(metadata: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt as _;
    (metadata.dev(), metadata.ino())
}

/// Elsewhere length and header must do.
#[cfg(not(unix))]
fn place(_: &Metadata) -> (u64, u64) {
    (0, 0)
}
