//! All that is known about an index.

use grasp_index::{Catalogue, DescriptorKind, DescriptorParams, Index, Section, Sigma};
use serde::Serialize;

use crate::search::{HashInfo, MeasuredInfo};
use crate::vote::VoteInfo;

/// All that is known about an index.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IndexInfo {
    /// The file, as it was named.
    pub file: String,
    /// How many entries it holds.
    pub entries: usize,
    /// Its length.
    pub bytes: u64,
    /// Whether it can tell what pictures show.
    pub recognises: bool,
    /// How its descriptors were made.
    pub descriptor: DescriptorInfo,
    /// The form in which it keeps them: `f32`, `f16` or `none`.
    pub originals: &'static str,
    /// What it keeps of each entry besides.
    pub keeps: Vec<&'static str>,
    /// Its classes.
    pub classes: Vec<ClassCount>,
    /// The names of its hand shapes.
    pub hand_shapes: Vec<String>,
    /// The names of its stages.
    pub stages: Vec<String>,
    /// Equation 5.
    pub sigma: SigmaInfo,
    /// How neighbours are weighed.
    pub vote: VoteInfo,
    /// The hash; null for a kind that this version does not know.
    pub hash: Option<HashInfo>,
    /// How well it finds.
    pub measured: MeasuredInfo,
    /// The side of its thumbnails in pixels; 0 where there are none.
    pub thumbnail_side: u32,
    /// What all randomness came from.
    pub seed: u64,
    /// Where it comes from, as its builder states it.
    pub provenance: Vec<Provenance>,
    /// Where its arrays lie.
    pub sections: Vec<SectionInfo>,
}

/// How descriptors were made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DescriptorInfo {
    /// Its name in the options of the builder.
    pub name: &'static str,
    /// Values of a descriptor.
    pub dim: usize,
    /// Bins of orientation.
    pub bins: u32,
    /// Levels of the pyramid.
    pub levels: u32,
    /// How a hand image becomes the picture that is described.
    pub sampling: String,
    /// What is done to its grey.
    pub tone: String,
    /// The fingerprint of the network that describes it, where one does.
    pub network: Option<String>,
}

/// A class and how many entries it has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ClassCount {
    /// Its name, such as `pinch`.
    pub name: String,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// How many entries.
    pub entries: usize,
}

/// Equation 5, measured over the entries.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SigmaInfo {
    /// As its words say: the mean distance within a class.
    pub mean_distance: f64,
    /// As it is printed.
    pub literal: f64,
}

/// A statement of the builder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Provenance {
    /// Of what.
    pub name: String,
    /// What.
    pub value: String,
}

/// Where an array lies.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SectionInfo {
    /// What it holds.
    pub kind: String,
    /// The type of its elements.
    pub element: String,
    /// Its first byte.
    pub offset: u64,
    /// Its length in bytes.
    pub bytes: u64,
    /// The hash of its bytes, in hexadecimal digits.
    pub xxh3: String,
}

impl IndexInfo {
    /// Reads the label of each entry; everything else stands in the catalogue.
    pub fn new(file: String, index: &Index) -> Self {
        let catalogue = index.catalogue();
        let classes = catalogue.classes.iter().zip(class_counts(index));
        let classes = classes.map(|(class, entries)| ClassCount {
            name: class.name.clone(),
            cutkosky: class.cutkosky,
            entries,
        });
        Self {
            file,
            entries: index.len(),
            bytes: index.byte_len(),
            recognises: index.check_recognises().is_ok(),
            descriptor: DescriptorInfo::new(&catalogue.descriptor, index.dim()),
            originals: catalogue.originals.name(),
            keeps: catalogue.kept.names(),
            classes: classes.collect(),
            hand_shapes: catalogue.hand_shapes.clone(),
            stages: catalogue.stages.clone(),
            sigma: SigmaInfo::from(&catalogue.sigma),
            vote: VoteInfo::from(&catalogue.calibration),
            hash: HashInfo::from_hash(&catalogue.hash),
            measured: MeasuredInfo::from(&catalogue.measured),
            thumbnail_side: catalogue.thumbnail_side,
            seed: catalogue.seed,
            provenance: provenance(catalogue),
            sections: catalogue.sections.iter().map(SectionInfo::from).collect(),
        }
    }
}

/// How many entries each class has, in the catalogue's order.
pub fn class_counts(index: &Index) -> Vec<usize> {
    let mut counts = vec![0; index.catalogue().classes.len()];
    for &label in index.labels() {
        if let Some(count) = counts.get_mut(usize::from(label)) {
            *count += 1;
        }
    }
    counts
}

fn provenance(catalogue: &Catalogue) -> Vec<Provenance> {
    let statements = catalogue.provenance.iter();
    statements.map(|(name, value)| Provenance { name: name.clone(), value: value.clone() }).collect()
}

impl DescriptorInfo {
    fn new(descriptor: &DescriptorParams, dim: usize) -> Self {
        let network = match descriptor.kind {
            // As `grasp-builder train` prints it.
            DescriptorKind::Learned { network, .. } => Some(format!("{network:016x}")),
            _ => None,
        };
        Self {
            name: descriptor.name(),
            dim,
            bins: descriptor.bins,
            levels: descriptor.levels,
            sampling: format!("{:?}", descriptor.sampling),
            tone: format!("{:?}", descriptor.tone),
            network,
        }
    }
}

impl From<&Sigma> for SigmaInfo {
    fn from(sigma: &Sigma) -> Self {
        Self { mean_distance: sigma.mean_distance, literal: sigma.literal }
    }
}

impl From<&Section> for SectionInfo {
    fn from(section: &Section) -> Self {
        Self {
            kind: format!("{:?}", section.kind),
            element: format!("{:?}", section.element),
            offset: section.offset,
            bytes: section.length,
            xxh3: format!("{:016x}", section.xxh3),
        }
    }
}
