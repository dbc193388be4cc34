//! What the index that is to be replaced knows already.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::{DescriptorParams, Index, NewEntry, OpenError, Originals};
use grasp_terminal::text::shown;
use tracing::warn;

use super::inputs::Inputs;

/// Descriptors of an existing index, by the hash of what they were made from. Empty where there is
/// none to use.
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
    /// A damaged index is no source of descriptors, and will be replaced; a file that is no index
    /// at all is somebody's work, and is left alone with an error.
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
        // Rounded descriptors would make another hash than those that they were rounded from;
        // without views there is no telling how a picture was turned.
        let exact = index.catalogue().originals == Originals::F32 && index.catalogue().kept.views;
        let hashes = if exact { index.source_hashes() } else { &[] };
        let ids = hashes.iter().zip(0..).map(|(&hash, id)| (hash, id)).collect();
        Ok(Self { index: Some(index), ids })
    }

    /// Says that a damaged index will not be built upon.
    fn useless(path: &Path, why: &str) -> Self {
        warn!(
            subject = env!("CARGO_PKG_NAME"),
            "nothing can be taken over from the existing {}, which will be replaced: {why}",
            shown(path)
        );
        Self::nothing()
    }

    /// Whether what was taken over may be believed: asked before anything is made of it.
    ///
    /// # Errors
    /// Where the existing index was overwritten meanwhile.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        let Some(index) = &self.index else { return Ok(()) };
        index.check_unchanged().context("cannot take over what the existing index holds")
    }

    /// Whether a picture with this source hash is known.
    pub(super) fn contains(&self, source_hash: u64) -> bool {
        self.ids.contains_key(&source_hash)
    }

    /// What a picture with this source hash, seen with this roll, was made into.
    pub(super) fn get(&self, source_hash: u64, roll_deg: f32) -> Option<KnownPicture> {
        let id = *self.ids.get(&source_hash)?;
        let NewEntry { descriptor, thumbnail, roll_deg: turned, .. } =
            self.index.as_ref()?.new_entry(id).ok()?;
        // The turn was taken from the roll, in tenths; what is kept of the roll is finer.
        let turn = ((f64::from(roll_deg) - f64::from(turned)) * 10.0).round().rem_euclid(3600.0);
        let turn_deg = if turn < 1800.0 { turn / 10.0 } else { (turn - 3600.0) / 10.0 };
        Some(KnownPicture { descriptor, thumbnail, turn_deg })
    }

    /// Whether the existing index is, byte for byte, what these inputs make.
    pub(super) fn is_made_from(&self, inputs: &Inputs) -> bool {
        self.index.as_ref().is_some_and(|index| index.catalogue().provenance == inputs.provenance())
    }
}

/// A picture as the existing index has it.
pub(super) struct KnownPicture {
    pub(super) descriptor: Vec<f32>,
    pub(super) thumbnail: Option<Vec<u8>>,
    /// As [`DescriptorParams::turn_deg`] told it.
    pub(super) turn_deg: f64,
}
