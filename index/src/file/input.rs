//! What an index is made from, and what comes of it.

use super::atomic::WriteError;
use super::catalogue::ClassInfo;
use super::kept::KeptFields;
use crate::descriptor::{DescriptorParams, ParamsError};
use crate::rotation::turned_orientation;
use crate::search::Originals;
use crate::search::build::HashParams;
use crate::search::distance::LARGEST_VALUE;
use crate::search::effort::Measured;
use crate::search::hash::HashInfo;
use crate::vote::{Calibration, Sigma};
use grasp_network::Network;
use nalgebra::UnitQuaternion;
use std::sync::Arc;
use thiserror::Error;

/// What an index is to be like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IndexParams {
    /// How the descriptors were made.
    pub descriptor: DescriptorParams,
    /// The network that makes learned descriptors; ignored for others.
    pub network: Option<Arc<Network>>,
    /// Which form of the descriptors to keep. [`Originals::F32`] alone serves a random hash, which
    /// has nothing else to measure distances by.
    pub originals: Originals,
    /// What to keep of each entry besides; the rest of what [`NewEntry`] says is ignored.
    pub kept: KeptFields,
    /// The classes, at most 65,536. Where labels are kept, there is at least one, as there is of
    /// the two lists that follow.
    pub classes: Vec<ClassInfo>,
    /// The names of the hand shapes, at most 65,536.
    pub hand_shapes: Vec<String>,
    /// The names of the stages, at most 256.
    pub stages: Vec<String>,
    /// Which hash, and how it is sized.
    pub hash: HashParams,
    /// Descriptors from outside the index, rows of [`DescriptorParams::dim`] values: what the
    /// search is tuned and measured with. Those of hand shapes that the index does not hold are
    /// best. Without [`Self::held_out_classes`] they are what will be searched for, and measured
    /// with as they are; of known classes they are taken for renders, and moved by
    /// [`NOISE`](crate::NOISE) first. Where there are none, the index's own are used, so moved,
    /// each held out for its own query.
    pub held_out: Vec<f32>,
    /// What those show, a position in [`Self::classes`] a row: what the vote is calibrated with.
    /// Nothing where that is not known.
    pub held_out_classes: Vec<u16>,
    /// What all randomness comes from.
    pub seed: u64,
    /// The side of the thumbnails in pixels, at most 1024; 0 keeps none.
    pub thumbnail_side: u32,
    /// How neighbours are weighed where there are no [`Self::held_out_classes`] to find that out
    /// by.
    pub calibration: Calibration,
    /// Names and values to keep with the index, such as where its renders come from. No dates,
    /// where a rebuild is to give the same bytes.
    pub provenance: Vec<(String, String)>,
}

/// One entry on its way into an index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewEntry {
    /// A position in [`IndexParams::classes`].
    pub class: u16,
    /// A position in [`IndexParams::stages`].
    pub stage: u8,
    /// A position in [`IndexParams::hand_shapes`].
    pub hand_shape: u16,
    /// What the hand holds.
    pub object: String,
    /// The picture's file name.
    pub file: String,
    /// The camera's azimuth, in degrees; kept to a hundredth, as are the other two, and modulo a
    /// full turn.
    pub azimuth_deg: f32,
    /// The camera's elevation, in degrees.
    pub elevation_deg: f32,
    /// The camera's roll, in degrees.
    pub roll_deg: f32,
    /// `camera_from_hand`; kept to 0.0035 degrees.
    pub orientation: UnitQuaternion<f64>,
    /// A hash of what the descriptor was made from, by which a rebuild knows it again.
    pub source_hash: u64,
    /// The descriptor: [`DescriptorParams::dim`] finite values.
    pub descriptor: Vec<f32>,
    /// A picture of [`IndexParams::thumbnail_side`] squared grey values, if any.
    pub thumbnail: Option<Vec<u8>>,
}

impl NewEntry {
    /// The entry, had its picture been turned clockwise by `turn_deg` degrees, as
    /// [`DescriptorParams::turn_deg`] says: its orientation and its camera's roll are those of the
    /// turned picture. Its descriptor and thumbnail stay.
    #[must_use]
    pub fn turned(self, turn_deg: f64) -> Self {
        let orientation = turned_orientation(turn_deg, &self.orientation);
        // A camera that rolls one way sees the picture turn the other way.
        let roll_deg = (f64::from(self.roll_deg) - turn_deg).rem_euclid(360.0) as f32;
        Self { orientation, roll_deg, ..self }
    }
}

/// Why an entry does not fit its index.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum EntryFault {
    /// Its descriptor is of another length.
    #[error("its descriptor has {found} values, the index's have {expected}")]
    Dimension {
        /// The values that it has.
        found: usize,
        /// Those that the index's have.
        expected: usize,
    },
    /// A value of its descriptor is infinite or not a number.
    #[error("value {at} of its descriptor is not a finite number")]
    NotFinite {
        /// Which, counted from 0.
        at: usize,
    },
    /// A value of its descriptor is so large that distances would not be finite.
    #[error(
        "value {at} of its descriptor is beyond {LARGEST_VALUE:e}: divide all descriptors by the same number"
    )]
    Huge {
        /// Which, counted from 0.
        at: usize,
    },
    /// A value of its descriptor does not fit into half precision.
    #[error("value {at} of its descriptor is too large for 16 bits: keep the originals as f32")]
    TooLarge {
        /// Which, counted from 0.
        at: usize,
    },
    /// An angle of its view is infinite or not a number.
    #[error("its view is not made of finite numbers")]
    View,
    /// Its orientation is no rotation.
    #[error("its orientation is not a unit quaternion")]
    Orientation,
    /// One of its numbers names nothing of the index.
    #[error("its {what} is number {number}, and the index has {count}")]
    Number {
        /// What it numbers.
        what: &'static str,
        /// The number, counted from 0.
        number: usize,
        /// How many the index has.
        count: usize,
    },
    /// Its thumbnail is of another size.
    #[error("its thumbnail is not of the size of the index's own ({found} and {expected} pixels)")]
    Thumbnail {
        /// The pixels that it has.
        found: usize,
        /// Those that the index's have.
        expected: usize,
    },
}

/// Why an index cannot be built.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The descriptor's parameters are out of range.
    #[error(transparent)]
    Descriptor(#[from] ParamsError),
    /// Something else about the index is out of range.
    #[error("{0}")]
    Params(&'static str),
    /// An entry does not fit the index.
    #[error("the entry {file} cannot be added: {what}")]
    Entry {
        /// The entry's file name.
        file: String,
        /// What does not fit.
        what: EntryFault,
    },
    /// Nothing was added.
    #[error("the index would be empty: add at least one entry")]
    Empty,
    /// There is more than the format can number.
    #[error("{0} are more than one index can hold: build several indexes")]
    TooMany(&'static str),
    /// The file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The index has no file to be written to.
    #[error(
        "the index is built in memory: take its bytes with `finish_bytes`, or start it with `IndexWriter::create`"
    )]
    InMemory,
    /// The caller's callback asked to stop.
    #[error("stopped before the index was written")]
    Stopped,
}

/// An index that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// How many entries it holds.
    pub entries: u64,
    /// The file's length in bytes.
    pub bytes: u64,
    /// Equation 5.
    pub sigma: Sigma,
    /// How neighbours are weighed.
    pub calibration: Calibration,
    /// The hash that was chosen.
    pub hash: HashInfo,
    /// How well it does.
    pub measured: Measured,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn an_entry_of_a_turned_picture_has_the_turned_hand_and_the_roll_that_shows_it() {
        let entry = NewEntry { roll_deg: 10.0, file: "a.png".into(), ..NewEntry::default() };
        let turned = entry.clone().turned(30.0);
        // Clockwise on the picture: what pointed right points down as well.
        let right = turned.orientation * Vector3::x();
        assert!((right - Vector3::new(0.75f64.sqrt(), 0.5, 0.0)).norm() < 1e-12, "{right}");
        assert_eq!(turned.roll_deg, 340.0);
        assert_eq!(turned.file, "a.png");
        let back = turned.turned(-30.0);
        assert_eq!(back.roll_deg, 10.0);
        assert!(back.orientation.angle_to(&entry.orientation) < 1e-12);
    }
}
