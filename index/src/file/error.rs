//! Why a file cannot be used as an index.

use std::fmt;
use thiserror::Error;

use super::corruption::Corruption;

/// The file of an index was changed in place while it was in use, so that what was read of it may
/// be of two files.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error(
    "the file was overwritten or cut short while it was in use: try again when it is whole; `mv` a new index over the old one, which disturbs nobody, instead of copying it there"
)]
pub struct FileChanged;

/// Why a file cannot be used as an index. The messages do not name the file: the caller, who does,
/// knows it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The operating system refused.
    #[error("cannot read it")]
    Io(#[from] std::io::Error),
    /// The file was to be read into memory, and there is not enough.
    #[error("{} do not fit into memory: map the file instead of reading it", Size(*.length))]
    NoMemory {
        /// The file's length in bytes.
        length: u64,
    },
    /// The path names a folder.
    #[error("it is a folder: name the index file itself")]
    Folder,
    /// The path names a pipe or a device, which cannot be mapped.
    #[error("it is not a regular file: copy it into one first")]
    NotAFile,
    /// The file holds nothing.
    #[error("the file is empty: build the index again")]
    Empty,
    /// The file is something else.
    #[error("not a grasp index: build one with `grasp-builder build --out FILE`")]
    NotAnIndex,
    /// The end of the file is missing.
    #[error("truncated: {expected} bytes expected, {found} found: copy or build the file again")]
    Truncated {
        /// The length that the header states, or that of a header, in bytes.
        expected: u64,
        /// The file's length in bytes.
        found: u64,
    },
    /// There is more than the header states.
    #[error("too long: {expected} bytes expected, {found} found: copy or build the file again")]
    TooLong {
        /// The length that the header states, in bytes.
        expected: u64,
        /// The file's length in bytes.
        found: u64,
    },
    /// The file needs a newer reader.
    #[error(
        "needs a reader of version {needs} or later, and this one is of version {reader}: use a newer grasp-query, or build the file again with this grasp-builder"
    )]
    TooNew {
        /// The least reader version that can read the file.
        needs: u32,
        /// This reader's version.
        reader: u32,
    },
    /// The file is of a version that is no longer read.
    #[error(
        "built by an older version of grasp-builder (format {wrote}; this reads {oldest} and later): build it again"
    )]
    TooOld {
        /// The version that wrote the file.
        wrote: u32,
        /// The oldest version that this reader reads.
        oldest: u32,
    },
    /// The descriptors follow a definition that this program no longer has, or does not have yet.
    #[error("its descriptors were made by another version of this program: build the index again")]
    OtherDescriptors,
    /// Another program wrote to the file while it was opened.
    #[error(transparent)]
    Changed(#[from] FileChanged),
    /// A part of the file is not what it was when it was written.
    #[error("corrupt: {0}: copy or build the file again")]
    Corrupt(Corruption),
}

// The corruption is part of the message, and so no source beside it.
impl From<Corruption> for OpenError {
    fn from(corruption: Corruption) -> Self {
        Self::Corrupt(corruption)
    }
}

/// A number of bytes for people.
struct Size(u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            bytes @ 0..100_000 => write!(f, "{bytes} bytes"),
            bytes @ 100_000..10_000_000 => write!(f, "{} kB", bytes / 1_000),
            bytes => write!(f, "{} MB", bytes / 1_000_000),
        }
    }
}
