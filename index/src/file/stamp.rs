//! Which content an open file had, to notice that another program has changed it.

use super::error::FileChanged;
use super::header;
use std::fs::{File, Metadata};
use std::io;
use std::time::{Duration, SystemTime};

/// A system counts the times of files in steps of up to 10 ms: a file changed so lately may change
/// again within the same step.
const STEP: Duration = Duration::from_millis(20);

/// An open file, and what it was like when it was opened.
///
/// Systems set a file's time of modification before a write changes the first byte, and its length
/// with truncation. If both are unchanged afterwards, everything read came from one version of the
/// file. Asking costs one system call (0.3 us).
#[derive(Debug)]
pub(crate) struct Stamp {
    file: File,
    times: Times,
    /// The file had been modified just before, so that its times are not enough.
    is_fresh: bool,
    head: Head,
}

/// The header of an index holds the hash of its catalogue, which holds that of every section:
/// another content has another one.
type Head = [u8; header::LENGTH];

impl Stamp {
    /// To be taken before the file is read or mapped.
    pub(crate) fn new(file: File) -> io::Result<Self> {
        let metadata = file.metadata()?;
        // A clock that is ahead of this one's says nothing of the file's age either.
        let is_old = |modified| SystemTime::now().duration_since(modified).is_ok_and(|age| age > STEP);
        let is_fresh = !metadata.modified().is_ok_and(is_old);
        Ok(Self { times: Times::new(&metadata), is_fresh, head: head(&file)?, file })
    }

    /// The file's length in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.times.length
    }

    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// Whether the file has the content that it had.
    pub(crate) fn check(&self) -> Result<(), FileChanged> {
        let now = self.file.metadata().map(|metadata| Times::new(&metadata)).map_err(|_| FileChanged)?;
        if now == self.times && !self.is_fresh {
            return Ok(());
        }
        // The time of the last change alone moves where the file was renamed, or another one was
        // renamed over it; and where it was overwritten and its time of modification set back, as
        // `cp --preserve` does.
        let is_same = now.length == self.times.length && now.modified == self.times.modified;
        let has_same_head = || head(&self.file).is_ok_and(|head| head == self.head);
        if is_same && has_same_head() { Ok(()) } else { Err(FileChanged) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Times {
    length: u64,
    modified: Option<SystemTime>,
    /// Seconds and nanoseconds of the last change of content, name or rights, which no program can
    /// set.
    changed: (i64, i64),
}

impl Times {
    fn new(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let changed = {
            use std::os::unix::fs::MetadataExt as _;
            (metadata.ctime(), metadata.ctime_nsec())
        };
        #[cfg(not(unix))]
        let changed = (0, 0);
        Self { length: metadata.len(), modified: metadata.modified().ok(), changed }
    }
}

/// The first bytes of a file; zeros beyond its end.
fn head(file: &File) -> io::Result<Head> {
    let mut head = [0; header::LENGTH];
    #[cfg(unix)]
    std::os::unix::fs::FileExt::read_at(file, &mut head, 0)?;
    #[cfg(windows)]
    std::os::windows::fs::FileExt::seek_read(file, &mut head, 0)?;
    #[cfg(not(any(unix, windows)))]
    let _ = file;
    Ok(head)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs::{self, FileTimes, Permissions};
    use std::os::unix::fs::PermissionsExt as _;
    use std::path::Path;

    fn stamp(path: &Path) -> Stamp {
        Stamp::new(File::open(path).unwrap()).unwrap()
    }

    #[test]
    fn every_way_to_overwrite_a_file_is_noticed_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        for rest in [Duration::ZERO, 2 * STEP] {
            // Also within the same step of the clock.
            let noticed = |change: &dyn Fn(&Path)| {
                fs::write(&path, [1; 1000]).unwrap();
                std::thread::sleep(rest);
                let stamp = stamp(&path);
                assert_eq!(stamp.check(), Ok(()));
                change(&path);
                assert_eq!(stamp.check(), Err(FileChanged), "after {rest:?}");
            };
            noticed(&|path| fs::write(path, [2; 1000]).unwrap());
            noticed(&|path| fs::write(path, [1; 1001]).unwrap());
            noticed(&|path| fs::write(path, []).unwrap());
            // `cp --preserve` of a file of the same length and time.
            noticed(&|path| {
                let modified = fs::metadata(path).unwrap().modified().unwrap();
                fs::write(path, [2; 1000]).unwrap();
                let file = File::options().write(true).open(path).unwrap();
                file.set_times(FileTimes::new().set_modified(modified)).unwrap();
            });
        }
    }

    #[test]
    fn what_leaves_the_content_alone_is_no_change() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, [1; 1000]).unwrap();
        std::thread::sleep(2 * STEP);
        let stamp = stamp(&path);
        fs::set_permissions(&path, Permissions::from_mode(0o400)).unwrap();
        assert_eq!(stamp.check(), Ok(()));
        let name = folder.path().join("other name");
        fs::rename(&path, &name).unwrap();
        assert_eq!(stamp.check(), Ok(()));
        fs::write(&path, [2; 1000]).unwrap();
        fs::rename(&path, &name).unwrap();
        assert_eq!(stamp.check(), Ok(()), "the file that was there has no name any more");
    }
}
