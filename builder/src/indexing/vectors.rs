//! Entries that came as vectors, described elsewhere.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::{KeptFields, NewEntry};
use grasp_renders::GraspSet;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::described::Take;
use super::labels::Labels;
use super::names::Names;
use crate::array::Rows;

/// An array of descriptors, and what is known of each, whose headers and labels have been read and
/// checked.
#[derive(Debug)]
pub struct Vectors {
    path: PathBuf,
    rows: u64,
    dim: u32,
    labels: Option<Labels>,
}

impl Vectors {
    /// Looks at the array in `descriptors`, and reads the labels, one line a row.
    ///
    /// # Errors
    /// When either cannot be used, or they do not fit each other.
    pub fn open(descriptors: &Path, labels: Option<&Path>, grasps: &GraspSet) -> anyhow::Result<Self> {
        let rows = Rows::open(descriptors)?;
        let Ok(dim) = u32::try_from(rows.columns()) else {
            bail!(
                "{} has rows of {} values: at most 65,536 are supported",
                descriptors.display(),
                rows.columns()
            );
        };
        let labels = labels.map(|path| Labels::open(path, grasps)).transpose()?;
        if let Some(labels) = labels.as_ref().filter(|labels| labels.len() != rows.len()) {
            bail!(
                "{} has {} lines and {} {} rows: one line a row is needed",
                labels.path().display(),
                labels.len(),
                descriptors.display(),
                rows.len()
            );
        }
        Ok(Self { path: descriptors.to_owned(), rows: rows.len(), dim, labels })
    }

    /// How many rows there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows as usize
    }

    /// Whether there are none; such an array is refused.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// Values of a row.
    #[must_use]
    pub fn dim(&self) -> u32 {
        self.dim
    }

    /// What the index says of its origin.
    pub(super) fn provenance(&self) -> String {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let labels =
            self.labels.as_ref().map_or_else(|| "no labels".to_owned(), |labels| name(labels.path()));
        format!("{}, {} x {}, {labels}", name(&self.path), self.rows, self.dim)
    }
}

pub(super) fn names(vectors: &Vectors) -> Names {
    let nothing = || Names { kept: KeptFields::nothing(), ..Names::default() };
    vectors.labels.as_ref().map_or_else(nothing, |labels| labels.names().clone())
}

/// Hands some of the rows to `take`, in order.
pub(super) fn describe(vectors: &Vectors, pieces: Range<usize>, take: Take<'_>) -> anyhow::Result<()> {
    let mut rows = Rows::open(&vectors.path)?;
    if (rows.len(), rows.columns()) != (vectors.rows, u64::from(vectors.dim)) {
        bail!("{} was changed while it was read", vectors.path.display());
    }
    let mut labels = vectors.labels.as_ref().map(Labels::entries).transpose()?;
    let mut at = pieces.start as u64;
    rows.narrow(at..pieces.end as u64).with_context(|| format!("cannot read {}", vectors.path.display()))?;
    if let Some(labels) = &mut labels {
        labels.skip(pieces.start)?;
    }
    while let Some(values) = rows.next().with_context(|| format!("cannot use {}", vectors.path.display()))? {
        let mut batch = Vec::new();
        for row in values.chunks_exact(vectors.dim as usize) {
            let mut entry =
                labels.as_mut().map_or_else(|| Ok(NewEntry::default()), |labels| labels.next())?;
            if entry.file.is_empty() {
                // Not kept, unless the table says so; messages name it.
                entry.file = format!("row {at}");
            }
            entry.source_hash = xxh3_64(bytemuck::cast_slice(row));
            batch.push(Some((NewEntry { descriptor: row.to_vec(), ..entry }, false)));
            at += 1;
        }
        take(batch)?;
    }
    Ok(())
}

/// A number for some of the rows, and for the labels.
pub(super) fn digest(vectors: &Vectors, pieces: Range<usize>) -> anyhow::Result<u64> {
    let mut hash = Xxh3::new();
    let cannot = || format!("cannot use {}", vectors.path.display());
    let mut rows = Rows::open(&vectors.path)?;
    rows.narrow(pieces.start as u64..pieces.end as u64).with_context(cannot)?;
    while let Some(values) = rows.next().with_context(cannot)? {
        hash.update(bytemuck::cast_slice(&values));
    }
    if let Some(labels) = &vectors.labels {
        let path = labels.path();
        hash.update(&fs::read(path).with_context(|| format!("cannot read {}", path.display()))?);
    }
    Ok(hash.digest())
}
