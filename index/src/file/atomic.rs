//! Writing a file so that nobody ever sees half of it.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file on its way to `path`: written beside it, under the name `.NAME.part`, and put in its
/// place by [`Self::commit`]. Dropped before that, it leaves the file at `path` as it was, and no
/// other file.
///
/// The part is locked while it is written, so that two writers to one path do not mix; the part of
/// a writer that was killed is taken over by the next.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    part: PathBuf,
    file: File,
    committed: bool,
}

/// Why a file was not written. What was at the path before is still there.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The operating system refused; a full disk is reported here.
    #[error("cannot write {}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Another process is writing the same file.
    #[error("another program is writing {}: wait for it to end, or choose another file", path.display())]
    Locked {
        /// The file that was to be written.
        path: PathBuf,
    },
    /// The path names a folder, a device or a pipe.
    #[error("{} is not a regular file: name the file to write", path.display())]
    NotAFile {
        /// What was to be written.
        path: PathBuf,
    },
    /// The folder that the file should go into is missing.
    #[error("there is no folder {}: create it first", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
}

impl AtomicFile {
    /// Starts to write `path`.
    ///
    /// # Errors
    /// [`WriteError`], before anything is written: the folder is missing or cannot be written, the
    /// path is no regular file, or another writer is at work on it.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        // A link to a file stays a link: what it points to is replaced.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let (Some(name), Some(folder)) = (path.file_name(), path.parent()) else {
            return Err(WriteError::NotAFile { path });
        };
        if fs::metadata(&path).is_ok_and(|metadata| !metadata.is_file()) {
            return Err(WriteError::NotAFile { path });
        }
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if !folder.is_dir() {
            return Err(WriteError::NoFolder { folder: folder.to_path_buf() });
        }
        let mut part_name = std::ffi::OsString::from(".");
        part_name.push(name);
        part_name.push(".part");
        let part = folder.join(part_name);
        let failed = |source| WriteError::Io { path: path.clone(), source };
        // A link in the part's place is none of ours: writing through it would overwrite a
        // stranger's file.
        if fs::symlink_metadata(&part).is_ok_and(|metadata| metadata.is_symlink()) {
            fs::remove_file(&part).map_err(failed)?;
        }
        let file = loop {
            let file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&part)
                .map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(WriteError::Locked { path }),
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
            // Between opening and locking, another writer may have finished and moved the part
            // away.
            if is_at(&file, &part).map_err(failed)? {
                break file;
            }
        };
        file.set_len(0).map_err(failed)?;
        Ok(Self { path, part, file, committed: false })
    }

    /// The file that will be replaced.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder that the file is in.
    pub(crate) fn folder(&self) -> &Path {
        self.part.parent().unwrap_or(Path::new("."))
    }

    /// Another handle to the file on its way, which may be read as well.
    pub(crate) fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Puts the file in its place: all of it is on the disk before the name changes hands.
    ///
    /// # Errors
    /// [`WriteError::Io`]; the file at the path is then as it was before.
    pub fn commit(mut self) -> Result<(), WriteError> {
        let placed = self.file.sync_all().and_then(|()| fs::rename(&self.part, &self.path));
        placed.map_err(|source| WriteError::Io { path: self.path.clone(), source })?;
        self.committed = true;
        // The new name outlasts a power failure once its folder is on the disk. Some file systems
        // cannot do that; the file is whole either way.
        if let Some(folder) = self.part.parent() {
            let _ = File::open(folder).and_then(|folder| folder.sync_all());
        }
        Ok(())
    }
}

/// The caller writes through a buffer of its own.
impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing can be done about a failure here, and the next writer takes the part over.
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Whether `path` still names the open `file`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let open = file.metadata()?;
    match fs::metadata(path) {
        Ok(named) => Ok((open.dev(), open.ino()) == (named.dev(), named.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Elsewhere an open file cannot be moved away.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> io::Result<bool> {
    Ok(path.exists())
}
