//! The catalogue: all that is known about an index besides its arrays.

use super::kept::KeptFields;
use super::sections::Section;
use crate::descriptor::DescriptorParams;
use crate::search::Originals;
use crate::search::effort::Measured;
use crate::search::hash::HashInfo;
use crate::vote::{Calibration, Sigma};

/// The parameters, names and measurements of an index, and where its sections lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Catalogue {
    /// How many entries the index holds.
    pub entries: u64,
    /// Values of a descriptor.
    pub dim: u32,
    /// How the descriptors were made.
    pub descriptor: DescriptorParams,
    /// [`DescriptorParams::fingerprint`] of the program that made them: another one's descriptors
    /// cannot be compared.
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
    pub kept: KeptFields,
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

impl Catalogue {
    /// The names of the classes, in their order.
    pub fn class_names(&self) -> Vec<String> {
        self.classes.iter().map(|class| class.name.clone()).collect()
    }
}

/// A grasp class.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassInfo {
    /// Its name, such as `pinch`.
    pub name: String,
    /// Its number in Cutkosky's taxonomy, such as 9.
    pub cutkosky: u8,
}
