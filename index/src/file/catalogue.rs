//! The catalogue: all that is known about an index besides its arrays.

use crate::descriptor::DescriptorParams;
use crate::file::sections::Section;
use crate::search::effort::Measured;
use crate::search::hash::HashInfo;
use crate::vote::{Calibration, Sigma};
use rkyv::{Archive, Deserialize, Serialize};

/// The parameters, names and measurements of an index, and where its sections lie.
#[derive(Archive, Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Catalogue {
    /// How many entries the index holds.
    pub entries: u64,
    /// Values of a descriptor.
    pub dim: u32,
    /// How the descriptors were made.
    pub descriptor: DescriptorParams,
    /// [`DescriptorParams::fingerprint`] of the program that made them: another one's descriptors cannot be compared.
    pub descriptor_fingerprint: u64,
    /// The classes; an entry's class is a position in this list.
    pub classes: Vec<ClassInfo>,
    /// The names of the hand shapes; an entry's hand shape is a position in this list.
    pub hand_shapes: Vec<String>,
    /// The names of the stages; an entry's stage is a position in this list.
    pub stages: Vec<String>,
    /// Which form of the descriptors the index keeps.
    pub originals: Originals,
    /// What it keeps of each entry besides.
    pub kept: Kept,
    /// How many different objects there are.
    pub objects: u32,
    /// Equation 5, as measured over the entries.
    pub sigma: Sigma,
    /// How neighbours are best weighed.
    pub calibration: Calibration,
    /// What all randomness came from.
    pub seed: u64,
    /// The hash behind the buckets.
    pub hash: HashInfo,
    /// How well the hash does.
    pub measured: Measured,
    /// The side of the thumbnails in pixels; 0 where there are none.
    pub thumbnail_side: u32,
    /// Where the index comes from: names and values, as its builder states them.
    pub provenance: Vec<(String, String)>,
    /// Where every section lies, in the order of the file.
    pub sections: Vec<Section>,
}

/// Which form of the descriptors an index keeps, besides what its hash makes of them.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Originals {
    /// As they are: distances are exact.
    #[default]
    F32,
    /// In half the space: distances are right to about 0.1 %.
    F16,
    /// Not at all: distances are as exact as the codes of a learned hash.
    None,
}

impl Originals {
    /// All forms.
    pub const ALL: [Self; 3] = [Self::F32, Self::F16, Self::None];

    /// `f32`, `f16` or `none`.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::None => "none",
        }
    }

    /// The form of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|originals| originals.name() == name)
    }
}

/// What an index keeps of each entry besides its descriptor. What it does not keep takes no space.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Class, stage, hand shape and object. Without them neighbours are found, but cannot vote.
    pub labels: bool,
    /// `camera_from_hand`. Without it neighbours vote on the class alone.
    pub orientations: bool,
    /// The camera's azimuth, elevation and roll.
    pub views: bool,
    /// The file name.
    pub files: bool,
    /// The hash of what the descriptor was made from. Without it a rebuild starts from nothing.
    pub sources: bool,
}

impl Default for Kept {
    /// Everything.
    fn default() -> Self {
        Self { labels: true, orientations: true, views: true, files: true, sources: true }
    }
}

impl Kept {
    /// The names of what is kept.
    pub fn names(&self) -> Vec<&'static str> {
        let Self { labels, orientations, views, files, sources } = *self;
        let all = [
            (labels, "labels"),
            (orientations, "orientations"),
            (views, "views"),
            (files, "files"),
            (sources, "sources"),
        ];
        all.into_iter().filter_map(|(is_kept, name)| is_kept.then_some(name)).collect()
    }

    /// Nothing.
    pub fn nothing() -> Self {
        Self { labels: false, orientations: false, views: false, files: false, sources: false }
    }
}

/// A grasp class.
#[derive(Archive, Serialize, Deserialize, Clone, Debug, PartialEq, Eq)]
pub struct ClassInfo {
    /// Its name, such as `pinch`.
    pub name: String,
    /// Its number in Cutkosky's taxonomy, such as 9.
    pub cutkosky: u8,
}
