//! An opened index.

use crate::file::OpenError;
use crate::file::bytes::Bytes;
use crate::file::catalogue::{Catalogue, HashInfo};
use crate::file::open::Opened;
use crate::file::sections::SectionKind;
use crate::file::verify::{Verification, verify};
use crate::hand_image::HandImage;
use crate::search::random::RandomHyperplanes;
use crate::search::searcher::Searcher;
use crate::search::tables::Buckets;
use crate::search::{Neighbour, Rows, Search, SearchError, SearchOptions};
use crate::vote::{self, Ballot, ClassScore, Vote, VoteOptions};
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;
use thiserror::Error;

/// An index, opened for searching. It can be shared between threads.
#[derive(Debug)]
pub struct Index {
    file: Opened,
}

/// One entry of an index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry<'a> {
    /// Its class, a position in [`Catalogue::classes`].
    pub class: u16,
    /// The picture's file name.
    pub file: &'a str,
    /// The name of the hand shape.
    pub hand_shape: &'a str,
    /// The name of the stage.
    pub stage: &'a str,
    /// What the hand holds.
    pub object: &'a str,
    /// The camera's azimuth, in degrees.
    pub azimuth_deg: f32,
    /// The camera's elevation, in degrees.
    pub elevation_deg: f32,
    /// The camera's roll, in degrees.
    pub roll_deg: f32,
    /// `camera_from_hand`.
    pub orientation: UnitQuaternion<f64>,
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
    /// The file says something about it that makes no sense.
    #[error("corrupt: the {what} of entry {id} makes no sense: run `grasp-builder verify` on the index")]
    Corrupt {
        /// The entry.
        id: u32,
        /// What about it.
        what: &'static str,
    },
}

impl Index {
    /// Opens an index by mapping its file: in a time that does not depend on its size. The file must not be changed or
    /// truncated meanwhile (replacing it by renaming, as [`crate::IndexWriter`] does, is no change); where that cannot be
    /// relied on, use [`Self::read`].
    ///
    /// # Errors
    /// [`OpenError`], when the file is no sound index.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Ok(Self { file: Opened::new(Bytes::map(path.as_ref())?)? })
    }

    /// Opens an index by reading its file into memory.
    ///
    /// # Errors
    /// [`OpenError`], when the file is no sound index.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Ok(Self { file: Opened::new(Bytes::read(path.as_ref())?)? })
    }

    /// Opens an index that is in memory already, such as one compiled into a program. The bytes are copied.
    ///
    /// # Errors
    /// [`OpenError`], when they are no sound index.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OpenError> {
        Ok(Self { file: Opened::new(Bytes::copy(bytes))? })
    }

    /// Checks every byte of the index, which opening does not.
    pub fn verify(&self) -> Verification {
        verify(&self.file)
    }

    /// Parameters, names and measurements.
    pub fn catalogue(&self) -> &Catalogue {
        &self.file.catalogue
    }

    /// How many entries there are, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "an index is never empty")]
    pub fn len(&self) -> usize {
        self.rows().len()
    }

    /// Values of a descriptor.
    pub fn dim(&self) -> usize {
        self.catalogue().dim as usize
    }

    /// How many bytes the file has.
    pub fn byte_len(&self) -> u64 {
        self.file.bytes.len() as u64
    }

    /// The descriptor of a hand image, made as the index's own were. [`crate::Describer`] does the same faster for many pictures.
    pub fn describe(&self, hand: &HandImage) -> Vec<f32> {
        self.catalogue().descriptor.describe(hand)
    }

    /// A search for as many neighbours as the index was calibrated with.
    pub fn search_options(&self) -> SearchOptions {
        SearchOptions { k: self.catalogue().calibration.k as usize, ..SearchOptions::default() }
    }

    /// Searches the index, query after query.
    pub fn searcher(&self) -> Searcher<'_> {
        let HashInfo::Random(size) = self.catalogue().hash;
        let hash = RandomHyperplanes {
            size,
            dim: self.dim(),
            normals: self.file.array(SectionKind::PlaneNormals),
            offsets: self.file.array(SectionKind::PlaneOffsets),
        };
        let buckets = Buckets {
            directory: self.file.array(SectionKind::BucketDirectory),
            ids: self.file.array(SectionKind::BucketIds),
        };
        Searcher::new(self.rows(), hash, buckets, self.catalogue().measured)
    }

    /// The nearest neighbours of a descriptor. For many queries, [`Self::searcher`] is faster.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn search(&self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        self.searcher().search(query, options)
    }

    /// What the neighbours say. Neighbours that are not in the index, or whose entry makes no sense, have no vote.
    pub fn vote(&self, neighbours: &[Neighbour], options: &VoteOptions) -> Vote {
        let catalogue = self.catalogue();
        let fitted = catalogue.calibration.sigma_scale * catalogue.sigma.mean_distance;
        let sigma = match (options.sigma, options.sigma_scale) {
            (Some(sigma), _) => sigma,
            (None, Some(scale)) => scale * catalogue.sigma.mean_distance,
            (None, None) if options.literal_sigma => catalogue.sigma.literal,
            (None, None) => fitted,
        };
        let ballots: Vec<Ballot> = neighbours.iter().filter_map(|neighbour| self.ballot(neighbour)).collect();
        let shares = vote::probabilities(&ballots, catalogue.classes.len(), sigma);
        let scores = (0u16..).zip(&catalogue.classes).zip(shares);
        let mut classes: Vec<ClassScore> = scores
            .map(|((class, info), probability)| ClassScore {
                class,
                name: info.name.clone(),
                cutkosky: info.cutkosky,
                probability,
            })
            .collect();
        // Stable: equals stay in the order of their numbers.
        classes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let first = classes.first().map_or(0, |score| score.class);
        Vote {
            kernel_mass: vote::kernel_mass(&ballots, sigma),
            orientation: vote::estimate(&ballots, first, sigma, options.euler_mean),
            classes,
        }
    }

    fn ballot(&self, neighbour: &Neighbour) -> Option<Ballot> {
        let class = *self.labels().get(neighbour.id as usize)?;
        let orientation = self.orientation(neighbour.id)?;
        let distance = f64::from(neighbour.distance);
        let counts = (class as usize) < self.catalogue().classes.len() && distance.is_finite();
        counts.then_some(Ballot { class, distance, orientation })
    }

    /// Everything about an entry besides its descriptor and thumbnail.
    ///
    /// # Errors
    /// [`EntryError`], when there is no such entry or the file says something about it that makes no sense.
    pub fn entry(&self, id: u32) -> Result<Entry<'_>, EntryError> {
        let at = id as usize;
        let class = *self.labels().get(at).ok_or(EntryError::NoSuchEntry { id, entries: self.len() })?;
        let corrupt = |what| EntryError::Corrupt { id, what };
        let catalogue = self.catalogue();
        if class as usize >= catalogue.classes.len() {
            return Err(corrupt("class"));
        }
        let hand_shapes: &[u16] = self.file.array(SectionKind::HandShapes);
        let stages: &[u8] = self.file.array(SectionKind::Stages);
        let objects: &[u32] = self.file.array(SectionKind::Objects);
        let views: &[[f32; 3]] = self.file.array(SectionKind::Views);
        let object = objects.get(at).and_then(|&object| {
            self.file.text(SectionKind::ObjectOffsets, SectionKind::ObjectText, object as usize)
        });
        let hand_shape = hand_shapes.get(at).and_then(|&hand| catalogue.hand_shapes.get(hand as usize));
        let stage = stages.get(at).and_then(|&stage| catalogue.stages.get(stage as usize));
        let [azimuth_deg, elevation_deg, roll_deg] = *views.get(at).ok_or(corrupt("view"))?;
        Ok(Entry {
            class,
            file: self
                .file
                .text(SectionKind::FileOffsets, SectionKind::FileText, at)
                .ok_or(corrupt("file name"))?,
            hand_shape: hand_shape.ok_or(corrupt("hand shape"))?,
            stage: stage.ok_or(corrupt("stage"))?,
            object: object.ok_or(corrupt("object"))?,
            azimuth_deg,
            elevation_deg,
            roll_deg,
            orientation: self.orientation(id).ok_or(corrupt("orientation"))?,
        })
    }

    /// `camera_from_hand`; `None` where there is no such entry or what the file has is no rotation.
    fn orientation(&self, id: u32) -> Option<UnitQuaternion<f64>> {
        let orientations: &[[f32; 4]] = self.file.array(SectionKind::Orientations);
        let [x, y, z, w] = orientations.get(id as usize)?.map(f64::from);
        let rotation = Quaternion::new(w, x, y, z);
        let is_unit = (rotation.norm() - 1.0).abs() < 1e-2;
        is_unit.then(|| UnitQuaternion::new_normalize(rotation))
    }

    /// The picture of an entry: [`Catalogue::thumbnail_side`] squared grey values, row-major. `None` where it has none.
    pub fn thumbnail(&self, id: u32) -> Option<&[u8]> {
        let pixels = (self.catalogue().thumbnail_side as usize).pow(2);
        let start = (id as usize).checked_mul(pixels)?;
        let end = start.checked_add(pixels)?;
        let thumbnail = self.file.raw(SectionKind::Thumbnails).get(start..end)?;
        thumbnail.iter().any(|&grey| grey != 0).then_some(thumbnail)
    }

    /// The descriptor of an entry; `None` where there is no such entry.
    pub fn descriptor(&self, id: u32) -> Option<&[f32]> {
        self.rows().get(id)
    }

    /// The class of each entry, in the order of their numbers.
    pub fn labels(&self) -> &[u16] {
        self.file.array(SectionKind::Labels)
    }

    /// The hash, for each entry, of what its descriptor was made from: a rebuild may take over the descriptor of an entry
    /// with the same hash, if [`Self::params_hash`] has not changed either.
    pub fn source_hashes(&self) -> &[u64] {
        self.file.array(SectionKind::SourceHashes)
    }

    /// [`crate::DescriptorParams::fingerprint`] of the index's descriptors.
    pub fn params_hash(&self) -> u64 {
        self.catalogue().descriptor_fingerprint
    }

    fn rows(&self) -> Rows<'_> {
        Rows { values: self.file.array(SectionKind::Descriptors), dim: self.dim() }
    }
}
