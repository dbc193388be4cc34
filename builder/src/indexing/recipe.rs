//! What kind of index to make.

use grasp_index::{DescriptorModel, HashParams, IndexParams, Originals};

use super::names::Names;
use crate::held_out::HeldOut;
use crate::plan_spec::PlanSpec;

/// What kind of index to make of them.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// How hand images are described.
    pub descriptor: DescriptorModel,
    /// How the hash is sized.
    pub hash: HashParams,
    /// Which form of the descriptors is kept.
    pub originals: Originals,
    /// What the search is measured by.
    pub held_out: HeldOut,
    /// How the held-out hands are seen, and the index's own if it renders them: the index keeps it
    /// for those that are added later. `None` where no hand is rendered.
    pub seen: Option<PlanSpec>,
    /// The side of the thumbnails in pixels; 0 keeps none.
    pub thumbnail_side: u32,
    /// What all randomness comes from.
    pub seed: u64,
}

impl Recipe {
    /// The parameters of an index whose entries go by `names`.
    pub(crate) fn params(&self, names: &Names) -> IndexParams {
        IndexParams {
            descriptor: *self.descriptor.params(),
            network: self.descriptor.network().cloned(),
            classes: names.classes.clone(),
            hand_shapes: names.hand_shapes.names.clone(),
            stages: names.stages.names.clone(),
            hash: self.hash,
            originals: self.originals,
            kept: names.kept,
            seed: self.seed,
            thumbnail_side: self.thumbnail_side,
            ..IndexParams::default()
        }
    }

    /// The held-out descriptors, in rows, and the number of each one's class, where these are
    /// known.
    pub(crate) fn held_out_rows(&self, names: &Names) -> anyhow::Result<(Vec<f32>, Vec<u16>)> {
        let rows = self.held_out.describe(&self.descriptor)?;
        // Where a set shows other grasps than its grasps' own file tells of, what is held out says
        // nothing about its vote.
        let classes: anyhow::Result<Vec<u16>> = rows.grasps.iter().map(|grasp| names.class(grasp)).collect();
        Ok((rows.descriptors, classes.unwrap_or_default()))
    }
}
