//! An entry of an index, read back.

use crate::file::input::NewEntry;
use crate::file::pack;
use crate::index::Index;
use nalgebra::UnitQuaternion;
use std::borrow::Cow;
use thiserror::Error;

/// One entry of an index: of what [`kept`](crate::Catalogue::kept) names, everything.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<'a> {
    /// Its class, a position in [`classes`](crate::Catalogue::classes).
    pub class: Option<u16>,
    /// The picture's file name; empty where the index keeps none.
    pub file: String,
    /// The name of the hand shape; empty where the index keeps none.
    pub hand_shape: &'a str,
    /// The name of the stage; empty where the index keeps none.
    pub stage: &'a str,
    /// What the hand holds; empty where the index keeps nothing of it.
    pub object: String,
    /// The camera's azimuth (0 to 360), elevation (-180 to 180) and roll (0 to 360), in degrees.
    pub view_deg: Option<[f32; 3]>,
    /// `camera_from_hand`.
    pub orientation: Option<UnitQuaternion<f64>>,
}

/// An entry that cannot be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum EntryError {
    /// There is no such entry.
    #[error("there is no entry {id}: the index holds {entries}, counted from 0")]
    NoSuchEntry {
        /// The number that was asked for.
        id: u32,
        /// How many entries there are.
        entries: usize,
    },
    /// It is to be read whole, and the index keeps no descriptors.
    #[error("the index keeps no descriptors, so that none of its entries can go into another")]
    NoDescriptor,
    /// The file says something about it that makes no sense.
    #[error("corrupt: the {what} of entry {id} is out of range: run `grasp-builder verify` on the index")]
    Corrupt {
        /// The entry.
        id: u32,
        /// What about it.
        what: &'static str,
    },
}

impl Index {
    /// Everything about an entry besides its descriptor and thumbnail.
    ///
    /// # Errors
    /// [`EntryError`], when there is no such entry or the file says something about it that makes
    /// no sense.
    pub fn entry(&self, id: u32) -> Result<Entry<'_>, EntryError> {
        if id as usize >= self.len() {
            return Err(EntryError::NoSuchEntry { id, entries: self.len() });
        }
        let kept = self.catalogue().kept;
        let (class, [hand_shape, stage], object) = match kept.labels {
            true => self.named(id).map(|(class, names, object)| (Some(class), names, object))?,
            false => (None, [""; 2], String::new()),
        };
        let corrupt = |what| EntryError::Corrupt { id, what };
        let view = || {
            let views = self.file.views();
            let [azimuth, elevation, roll] = *views.get(id as usize).ok_or(corrupt("view"))?;
            let degrees = pack::unpack_degrees;
            Ok([degrees(azimuth, false), degrees(elevation, true), degrees(roll, false)])
        };
        let file = || self.file.file_name(id as usize);
        let orientation = || self.orientation(id).ok_or(corrupt("orientation"));
        Ok(Entry {
            class,
            file: if kept.files { file().ok_or(corrupt("file name"))? } else { String::new() },
            hand_shape,
            stage,
            object,
            view_deg: kept.views.then(view).transpose()?,
            orientation: kept.orientations.then(orientation).transpose()?,
        })
    }

    /// An entry as it went into the index, so that it can go into another: written with the same
    /// names and parameters, what is kept of it has the same bytes again. The descriptor is as
    /// exact as [`originals`](crate::Catalogue::originals) says; the class, the hand shape and the
    /// stage are this index's numbers.
    ///
    /// # Errors
    /// [`EntryError`], when there is no such entry, the index keeps no descriptors, or the file
    /// says something about the entry that makes no sense.
    pub fn new_entry(&self, id: u32) -> Result<NewEntry, EntryError> {
        let entry = self.entry(id)?;
        let descriptor = self.descriptor(id).ok_or(EntryError::NoDescriptor)?.into_owned();
        let [azimuth_deg, elevation_deg, roll_deg] = entry.view_deg.unwrap_or_default();
        let orientations = self.file.orientations();
        let orientation = orientations.get(id as usize).copied().and_then(pack::unpack_as_packed);
        Ok(NewEntry {
            class: entry.class.unwrap_or_default(),
            stage: self.file.stages().get(id as usize).copied().unwrap_or_default(),
            hand_shape: self.file.hand_shapes().get(id as usize).copied().unwrap_or_default(),
            object: entry.object,
            file: entry.file,
            azimuth_deg,
            elevation_deg,
            roll_deg,
            orientation: orientation.unwrap_or_default(),
            source_hash: self.source_hashes().get(id as usize).copied().unwrap_or_default(),
            descriptor,
            thumbnail: self.thumbnail(id).map(<[u8]>::to_vec),
        })
    }

    /// The class of an entry, the names of its hand shape and stage, and that of its object.
    fn named(&self, id: u32) -> Result<(u16, [&str; 2], String), EntryError> {
        let (at, catalogue) = (id as usize, self.catalogue());
        let corrupt = |what| EntryError::Corrupt { id, what };
        let class = self.labels().get(at).filter(|&&class| usize::from(class) < catalogue.classes.len());
        let hand_shape =
            self.file.hand_shapes().get(at).and_then(|&hand| catalogue.hand_shapes.get(usize::from(hand)));
        let stage = self.file.stages().get(at).and_then(|&stage| catalogue.stages.get(usize::from(stage)));
        let object = self.file.objects().get(at).copied();
        let object = object.and_then(|object| self.file.object_name(usize::from(object)));
        let class = *class.ok_or(corrupt("class"))?;
        let names =
            [hand_shape.ok_or(corrupt("hand shape"))?.as_str(), stage.ok_or(corrupt("stage"))?.as_str()];
        Ok((class, names, object.ok_or(corrupt("object"))?))
    }

    /// `camera_from_hand`; `None` where there is no such entry or what the file has is no rotation.
    pub(crate) fn orientation(&self, id: u32) -> Option<UnitQuaternion<f64>> {
        let orientations = self.file.orientations();
        pack::unpack_rotation(*orientations.get(id as usize)?)
    }

    /// The picture of an entry: [`thumbnail_side`](crate::Catalogue::thumbnail_side) squared grey
    /// values, row-major. `None` where it has none.
    pub fn thumbnail(&self, id: u32) -> Option<&[u8]> {
        let pixels = (self.catalogue().thumbnail_side as usize).pow(2);
        let start = (id as usize).checked_mul(pixels)?;
        let end = start.checked_add(pixels)?;
        let thumbnail = self.file.thumbnails().get(start..end)?;
        thumbnail.iter().any(|&grey| grey != 0).then_some(thumbnail)
    }

    /// The descriptor of an entry, as exactly as [`originals`](crate::Catalogue::originals) says;
    /// `None` where there is no such entry, or descriptors are not kept.
    pub fn descriptor(&self, id: u32) -> Option<Cow<'_, [f32]>> {
        self.stored().get(id)
    }
}
