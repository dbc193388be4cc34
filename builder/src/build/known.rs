//! What the index that is to be replaced knows already.

use std::collections::HashMap;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::{DescriptorParams, Index, OpenError, Originals};

use super::inputs::Inputs;

/// Descriptors of an existing index, by the hash of what they were made from. Empty where there is none to use.
pub(crate) struct Known {
    index: Option<Index>,
    ids: HashMap<u64, u32>,
}

impl Known {
    /// Nothing is known.
    pub(crate) fn nothing() -> Self {
        Self { index: None, ids: HashMap::new() }
    }

    /// Looks at the file at `path`, if there is one.
    ///
    /// A damaged index is no source of descriptors, and will be replaced; a file that is no index at all is somebody's
    /// work, and is left alone with an error.
    pub(crate) fn at(
        path: &Path,
        descriptor: &DescriptorParams,
        thumbnail_side: u32,
    ) -> anyhow::Result<Self> {
        let index = match Index::open(path) {
            Ok(index) => index,
            Err(OpenError::Io(error)) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Self::nothing());
            }
            Err(
                error @ (OpenError::NotAnIndex | OpenError::NotAFile | OpenError::Folder | OpenError::Io(_)),
            ) => {
                return Err(error)
                    .with_context(|| format!("{} exists: choose another --out", path.display()));
            }
            Err(OpenError::TooNew { .. }) => {
                bail!(
                    "{} was written by a newer grasp-builder: use that one, or another --out",
                    path.display()
                )
            }
            Err(error) => {
                return Ok(Self::useless(path, &error.to_string()));
            }
        };
        let fits = index.params_hash() == descriptor.fingerprint()
            && index.catalogue().thumbnail_side == thumbnail_side;
        if !fits {
            return Ok(Self::nothing());
        }
        // Taking over one flipped bit would break "the same bytes as a build from nothing".
        if let Some(problem) = index.verify().problems.first() {
            return Ok(Self::useless(path, &problem.to_string()));
        }
        // Rounded descriptors would make another hash than those that they were rounded from.
        let exact = index.catalogue().originals == Originals::F32;
        let hashes = if exact { index.source_hashes() } else { &[] };
        let ids = hashes.iter().zip(0..).map(|(&hash, id)| (hash, id)).collect();
        Ok(Self { index: Some(index), ids })
    }

    /// Says that a damaged index will not be built upon.
    fn useless(path: &Path, why: &str) -> Self {
        // Where nobody listens any more, the build goes on all the same.
        let _ = writeln!(
            std::io::stderr(),
            "grasp-builder: the existing {} is of no use and will be replaced: {why}",
            path.display()
        );
        Self::nothing()
    }

    /// Whether a picture with this source hash is known.
    pub(super) fn contains(&self, source_hash: u64) -> bool {
        self.ids.contains_key(&source_hash)
    }

    /// Descriptor and thumbnail of a known picture.
    pub(super) fn get(&self, source_hash: u64) -> Option<(Vec<f32>, Option<Vec<u8>>)> {
        let id = *self.ids.get(&source_hash)?;
        let index = self.index.as_ref()?;
        Some((index.descriptor(id)?.into_owned(), index.thumbnail(id).map(<[u8]>::to_vec)))
    }

    /// Whether the existing index is, byte for byte, what these inputs make.
    pub(super) fn is_made_from(&self, inputs: &Inputs) -> bool {
        self.index.as_ref().is_some_and(|index| index.catalogue().provenance == inputs.provenance())
    }
}
