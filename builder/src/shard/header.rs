//! What a part is a part of.

use anyhow::{Context as _, bail};
use grasp_index::{
    ClassInfo, DescriptorModel, DescriptorParams, FORMAT_VERSION, HashParams, IndexParams, KeptFields,
    Originals, RandomParams,
};
use serde::{Deserialize, Serialize};

use super::share::Share;
use crate::descriptor;

/// Which part it is, and of which index. Equal headers mean equal parts; the headers of parts of
/// one index differ in the first two fields.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) share: Share,
    /// [`crate::indexing::Source::digest`] of the part's pieces.
    pub(crate) made_from: u64,
    /// Those of the index, but for what is held out.
    pub(crate) params: IndexParams,
    /// What is known beforehand of where the index comes from.
    pub(crate) origin: Vec<(String, String)>,
}

/// The same, as it is written.
#[derive(Serialize, Deserialize)]
struct Written {
    shard: u32,
    of: u32,
    made_from: u64,
    format: u32,
    descriptor: String,
    dim: u32,
    fingerprint: u64,
    originals: String,
    kept: [bool; 5],
    classes: Vec<(String, u8)>,
    hand_shapes: Vec<String>,
    stages: Vec<String>,
    hash: Hash,
    seed: u64,
    thumbnail_side: u32,
    origin: Vec<(String, String)>,
}

#[derive(Serialize, Deserialize)]
enum Hash {
    Learned,
    Random,
    Fixed { k: u32, t: u32, buckets: u32 },
}

impl Header {
    /// As a line of JSON.
    pub(crate) fn to_json(&self) -> anyhow::Result<Vec<u8>> {
        let Self { share, made_from, params, origin } = self;
        let KeptFields { labels, orientations, views, files, sources } = params.kept;
        let written = Written {
            shard: share.shard,
            of: share.of,
            made_from: *made_from,
            format: FORMAT_VERSION,
            descriptor: params.descriptor.name().to_owned(),
            dim: params.descriptor.dim() as u32,
            fingerprint: params.descriptor.fingerprint(),
            originals: params.originals.name().to_owned(),
            kept: [labels, orientations, views, files, sources],
            classes: params.classes.iter().map(|class| (class.name.clone(), class.cutkosky)).collect(),
            hand_shapes: params.hand_shapes.clone(),
            stages: params.stages.clone(),
            hash: match params.hash {
                HashParams::Learned => Hash::Learned,
                HashParams::Random(RandomParams::Auto) => Hash::Random,
                HashParams::Random(RandomParams::Fixed { k, t, buckets }) => Hash::Fixed { k, t, buckets },
            },
            seed: params.seed,
            thumbnail_side: params.thumbnail_side,
            origin: origin.clone(),
        };
        Ok(serde_json::to_vec(&written)?)
    }

    pub(crate) fn from_json(json: &[u8]) -> anyhow::Result<Self> {
        let written: Written = serde_json::from_slice(json).context("its header cannot be read")?;
        let descriptor = match written.descriptor.as_str() {
            "raw" => DescriptorModel::new(DescriptorParams::raw(written.dim))?,
            name => descriptor::by_name(name, None)?,
        };
        let network = descriptor.network().cloned();
        let descriptor = *descriptor.params();
        if written.format != FORMAT_VERSION || written.fingerprint != descriptor.fingerprint() {
            bail!("it was made by another version of grasp-builder");
        }
        let [labels, orientations, views, files, sources] = written.kept;
        let params = IndexParams {
            descriptor,
            network,
            originals: Originals::by_name(&written.originals)
                .context("its form of descriptors has no name")?,
            kept: KeptFields { labels, orientations, views, files, sources },
            classes: written
                .classes
                .into_iter()
                .map(|(name, cutkosky)| ClassInfo { name, cutkosky })
                .collect(),
            hand_shapes: written.hand_shapes,
            stages: written.stages,
            hash: match written.hash {
                Hash::Learned => HashParams::Learned,
                Hash::Random => HashParams::Random(RandomParams::Auto),
                Hash::Fixed { k, t, buckets } => HashParams::Random(RandomParams::Fixed { k, t, buckets }),
            },
            seed: written.seed,
            thumbnail_side: written.thumbnail_side,
            ..IndexParams::default()
        };
        let share =
            Share::new(written.shard, written.of).context("its header names a part that there cannot be")?;
        Ok(Self { share, made_from: written.made_from, params, origin: written.origin })
    }

    /// Whether both are parts of one index.
    pub(crate) fn goes_with(&self, other: &Self) -> bool {
        let Self { share, params, origin, .. } = self;
        share.of == other.share.of && *params == other.params && *origin == other.origin
    }
}
