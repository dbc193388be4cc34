//! The catalogue: all that is known about an index besides its arrays.

use crate::descriptor::DescriptorParams;
use crate::file::sections::Section;
use crate::search::random::RandomHash;
use crate::search::tune::Measured;
use crate::vote::Sigma;
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

/// A grasp class.
#[derive(Archive, Serialize, Deserialize, Clone, Debug, PartialEq, Eq)]
pub struct ClassInfo {
    /// Its name, such as `pinch`.
    pub name: String,
    /// Its number in Cutkosky's taxonomy, such as 9.
    pub cutkosky: u8,
}

/// How neighbours are best weighed: fitted by the builder on hand shapes that were held out.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How many neighbours vote.
    pub k: u32,
    /// The factor on [`Sigma::mean_distance`] that makes the kernel's width.
    pub sigma_scale: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { k: 10, sigma_scale: 1.0 }
    }
}

/// Which hash the buckets were made by.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HashInfo {
    /// The paper's random hyperplanes.
    Random(RandomHash),
}
