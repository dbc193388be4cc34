//! The index that a program answers by: where it lies when nobody names one, opening it, and
//! whether what it has said may be believed.

use std::error::Error;
use std::path::{Path, PathBuf};

use etcetera::base_strategy::{BaseStrategy as _, choose_native_strategy};
use grasp_index::Index;

/// What an index is called when neither an option nor the environment names one.
const DEFAULT: &str = "grasp.idx";
/// The folder that it has among a user's data.
const FOLDER: &str = "grasp";

/// An index that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IndexFileError {
    /// There is none.
    #[error(
        "no index at {}: put a release's {DEFAULT} at {}, build one with `grasp-builder build --out {DEFAULT}`, or name one \
         with --index or GRASP_INDEX",
        path.display(),
        users_path().unwrap_or_else(|| DEFAULT.into()).display()
    )]
    Missing {
        /// Where one was looked for.
        path: PathBuf,
    },
    /// It cannot be opened, knows nothing of pictures, or was changed while it was used.
    #[error("cannot use the index {}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<dyn Error + Send + Sync>,
    },
}

/// Where an index lies that nobody has named: in the working directory, among the user's data
/// (`$XDG_DATA_HOME/grasp/grasp.idx` on Linux), or beside this program, whichever is there first;
/// where none is, the first is where one is missed.
pub fn default_path() -> PathBuf {
    let program = std::env::current_exe().ok().map(|program| program.with_file_name(DEFAULT));
    let places = [Some(PathBuf::from(DEFAULT)), users_path(), program];
    places.into_iter().flatten().find(|path| path.exists()).unwrap_or_else(|| DEFAULT.into())
}

/// The index among the user's data, whether it is there or not; `None` for who has no home.
fn users_path() -> Option<PathBuf> {
    let folders = choose_native_strategy().ok();
    folders.map(|folders| folders.data_dir().join(FOLDER).join(DEFAULT))
}

/// Opens an index; `in_memory`: read instead of mapped.
///
/// # Errors
/// Where there is none, or it is damaged.
pub fn open(path: &Path, in_memory: bool) -> Result<Index, IndexFileError> {
    // What cannot be looked up may exist, and opening it says why it cannot.
    if matches!(path.try_exists(), Ok(false)) {
        return Err(IndexFileError::Missing { path: path.to_owned() });
    }
    let opened = if in_memory { Index::read(path) } else { Index::open(path) };
    opened.map_err(|error| unusable(path, error))
}

/// Opens an index that recognises pictures, as [`open`] does.
///
/// # Errors
/// As of [`open`], and where it holds raw vectors.
pub fn open_for_pictures(path: &Path, in_memory: bool) -> Result<Index, IndexFileError> {
    let index = open(path, in_memory)?;
    index.check_recognises().map_err(|error| unusable(path, error))?;
    Ok(index)
}

/// Whether what the index has said may be believed; to be asked after the work, and before anything
/// of it is written.
///
/// # Errors
/// Where its file was changed meanwhile.
pub fn check(path: &Path, index: &Index) -> Result<(), IndexFileError> {
    index.check_unchanged().map_err(|error| unusable(path, error))
}

fn unusable(path: &Path, error: impl Error + Send + Sync + 'static) -> IndexFileError {
    IndexFileError::Unusable { path: path.to_owned(), source: error.into() }
}
