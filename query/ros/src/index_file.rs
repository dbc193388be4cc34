//! Which index is used, and opening it; as the programs do.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use etcetera::base_strategy::{BaseStrategy as _, choose_native_strategy};
use grasp_index::Index;

/// Where an index lies that nobody has named: in the working directory, among the user's data, or
/// beside this program, whichever is there first.
fn default_path() -> PathBuf {
    const NAME: &str = "grasp.idx";
    let data = choose_native_strategy().ok().map(|folders| folders.data_dir().join("grasp").join(NAME));
    let program = std::env::current_exe().ok().map(|program| program.with_file_name(NAME));
    let places = [Some(PathBuf::from(NAME)), data, program];
    places.into_iter().flatten().find(|path| path.exists()).unwrap_or_else(|| NAME.into())
}

/// An index that recognises pictures, and its file.
#[derive(Debug)]
pub(crate) struct IndexFile {
    path: PathBuf,
    index: Index,
}

impl IndexFile {
    /// Opens the index of that name, or the default one; `in_memory`: read instead of mapped.
    ///
    /// # Errors
    /// Where there is none, or it is damaged, or holds no pictures.
    pub(crate) fn open(named: Option<PathBuf>, in_memory: bool) -> anyhow::Result<Self> {
        let path = named.unwrap_or_else(default_path);
        if !path.exists() {
            bail!(
                "no index at {}: build one with `grasp-builder build --out grasp.idx`, or name one with --index, GRASP_INDEX or \
                 the parameter index",
                path.display()
            );
        }
        let opened = if in_memory { Index::read(&path) } else { Index::open(&path) };
        let index = opened.with_context(|| cannot_use(&path))?;
        index.check_recognises().with_context(|| cannot_use(&path))?;
        Ok(Self { path, index })
    }

    /// The index.
    pub(crate) fn index(&self) -> &Index {
        &self.index
    }

    /// Its file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether what the index has said may be believed; to be asked after the work.
    ///
    /// # Errors
    /// Where its file was changed meanwhile.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        self.index.check_unchanged().with_context(|| cannot_use(&self.path))
    }
}

fn cannot_use(path: &Path) -> String {
    format!("cannot use the index {}", path.display())
}
