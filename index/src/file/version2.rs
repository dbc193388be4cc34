//! The catalogue as version 2 of the format has it: without what calibrates the vote.

use super::catalogue::{Catalogue, ClassInfo};
use super::kept::{Kept, Originals};
use super::sections::Section;
use crate::descriptor::DescriptorParams;
use crate::search::effort::Measured;
use crate::search::hash::HashInfo;
use crate::vote::{Calibration, Sigma};
use rkyv::{Archive, Deserialize};

/// The fields of [`Catalogue`], in the same order.
#[derive(Archive, Deserialize, Debug)]
pub(super) struct CatalogueOfVersion2 {
    entries: u64,
    dim: u32,
    descriptor: DescriptorParams,
    descriptor_fingerprint: u64,
    classes: Vec<ClassInfo>,
    hand_shapes: Vec<String>,
    stages: Vec<String>,
    originals: Originals,
    kept: Kept,
    objects: u32,
    sigma: Sigma,
    calibration: CalibrationOfVersion2,
    seed: u64,
    hash: HashInfo,
    measured: Measured,
    thumbnail_side: u32,
    provenance: Vec<(String, String)>,
    sections: Vec<Section>,
}

#[derive(Archive, Deserialize, Debug)]
struct CalibrationOfVersion2 {
    k: u32,
    sigma_scale: f64,
}

impl From<CatalogueOfVersion2> for Catalogue {
    fn from(old: CatalogueOfVersion2) -> Self {
        let CalibrationOfVersion2 { k, sigma_scale } = old.calibration;
        Self {
            entries: old.entries,
            dim: old.dim,
            descriptor: old.descriptor,
            descriptor_fingerprint: old.descriptor_fingerprint,
            classes: old.classes,
            hand_shapes: old.hand_shapes,
            stages: old.stages,
            originals: old.originals,
            kept: old.kept,
            objects: old.objects,
            sigma: old.sigma,
            calibration: Calibration { k, sigma_scale, ..Calibration::default() },
            seed: old.seed,
            hash: old.hash,
            measured: old.measured,
            thumbnail_side: old.thumbnail_side,
            provenance: old.provenance,
            sections: old.sections,
        }
    }
}
