//! An opened index.

use crate::descriptor::{Describer, DescriptorModel, NETWORK_STAGES};
use crate::file::atomic::AtomicFile;
use crate::file::bytes::Bytes;
use crate::file::catalogue::Catalogue;
use crate::file::error::FileChanged;
use crate::file::error::OpenError;
use crate::file::input::{BuildError, NewEntry};
use crate::file::open::Opened;
use crate::file::pack;
use crate::file::verify::{Verification, verify};
use crate::file::write::segment::write_segment;
use crate::hand_image::HandImage;
use crate::search::hash::HashInfo;
use crate::search::learned::axes::Axes;
use crate::search::learned::centres::Centres;
use crate::search::learned::{self, Learned, LearnedHash};
use crate::search::random::tables::Buckets;
use crate::search::random::{self, Random, RandomHyperplanes};
use crate::search::searcher::Searcher;
use crate::search::stored::Stored;
use crate::search::{Hash, Neighbour, ReadAhead, Search, SearchError, SearchOptions};
use crate::vote::{self, Ballot, ClassScore, Look, Vote, VoteOptions};
use nalgebra::UnitQuaternion;
use std::borrow::Cow;
use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Cutkosky's numbers of the grasps that networks are trained on, in the order of their heads.
const NETWORK_CLASSES: [u8; 6] = [1, 2, 4, 9, 10, 12];

/// An index, opened for searching. It can be shared between threads.
#[derive(Debug)]
pub struct Index {
    file: Opened,
    /// No search has been made yet, and the pages that one needs may have to come from the disk.
    is_cold: AtomicBool,
}

/// One entry of an index: of what [`Catalogue::kept`] names, everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry<'a> {
    /// Its class, a position in [`Catalogue::classes`].
    pub class: Option<u16>,
    /// The picture's file name; empty where the index keeps none.
    pub file: &'a str,
    /// The name of the hand shape; empty where the index keeps none.
    pub hand_shape: &'a str,
    /// The name of the stage; empty where the index keeps none.
    pub stage: &'a str,
    /// What the hand holds; empty where the index keeps nothing of it.
    pub object: &'a str,
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
    /// The file says something about it that makes no sense.
    #[error("corrupt: the {what} of entry {id} is out of range: run `grasp-builder verify` on the index")]
    Corrupt {
        /// The entry.
        id: u32,
        /// What about it.
        what: &'static str,
    },
}

/// Why an index cannot recognise what a picture shows, though it can be searched.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CannotRecognise {
    /// Its descriptors came from elsewhere.
    #[error(
        "the index holds raw vectors, and how to compute such a vector from a picture is not known: build it with --descriptor NAME if this program computed them, or search it for vectors with `grasp-query search`"
    )]
    RawDescriptors,
    /// It knows no classes.
    #[error(
        "the index holds descriptors without labels, so that neighbours have no class to vote for: build it with --labels FILE, or search it for vectors with `grasp-query search`"
    )]
    NoLabels,
}

impl Index {
    /// Opens an index by mapping its file: in a time that does not depend on its size. The file should not be changed or
    /// truncated meanwhile (replacing it by renaming, as [`crate::IndexWriter`] does, is no change): [`Self::check_unchanged`]
    /// says whether it was, and [`crate::guard_against_truncation`] keeps the process alive where it is. What
    /// [`Self::read`] has opened is beyond the reach of other programs.
    ///
    /// # Errors
    /// [`OpenError`], when the file is no sound index.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::new(Bytes::map(path.as_ref())?)
    }

    /// Opens an index by reading its file into memory.
    ///
    /// # Errors
    /// [`OpenError`], when the file is no sound index.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::new(Bytes::read(path.as_ref())?)
    }

    /// Opens an index that is in memory already, such as one compiled into a program. The bytes are copied.
    ///
    /// # Errors
    /// [`OpenError`], when they are no sound index.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OpenError> {
        Self::new(Bytes::copy(bytes))
    }

    fn new(bytes: Bytes) -> Result<Self, OpenError> {
        Ok(Self { file: Opened::new(bytes)?, is_cold: AtomicBool::new(true) })
    }

    /// Whether everything that this index has said until now was read from one and the same file. Where another program has
    /// overwritten or truncated the file that is mapped, answers may be wrong, and the index is never whole again: open the file anew.
    /// An index in memory cannot change. Costs one system call (0.3 us): ask after each answer, or after many.
    ///
    /// # Errors
    /// [`FileChanged`], where it was not.
    pub fn check_unchanged(&self) -> Result<(), FileChanged> {
        self.file.bytes.check_unchanged()
    }

    /// Writes some of the entries as an index of their own, with all that was learned and measured
    /// from all of them: the hash, the names, the curve of effort and the calibration. Segments of
    /// all entries, in order, are searched by [`crate::Segments`] exactly as this index is. Each
    /// entry is numbered from the first of the range. `provenance` is added to the index's own, and
    /// `proceed` may stop the work by breaking. Returns how many bytes the file has.
    ///
    /// # Errors
    /// [`BuildError`], where there are no such entries, the index is damaged or the file cannot be written; what was at its place is
    /// then as it was.
    pub fn write_segment(
        &self,
        entries: Range<u32>,
        provenance: Vec<(String, String)>,
        file: AtomicFile,
        proceed: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<u64, BuildError> {
        write_segment(&self.file, entries, provenance, file, proceed)
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
        // More than fit a usize were refused when the index was opened.
        self.catalogue().entries as usize
    }

    /// Values of a descriptor.
    pub fn dim(&self) -> usize {
        self.catalogue().dim as usize
    }

    /// How many bytes the file has.
    pub fn byte_len(&self) -> u64 {
        self.file.bytes.len() as u64
    }

    /// The descriptor of a hand image, made as the index's own were. [`Self::describer`] does the
    /// same faster for many pictures.
    ///
    /// # Errors
    /// [`CannotRecognise::RawDescriptors`].
    pub fn describe(&self, hand: &HandImage) -> Result<Vec<f32>, CannotRecognise> {
        let descriptor = &self.catalogue().descriptor;
        if !descriptor.describes_pictures() {
            return Err(CannotRecognise::RawDescriptors);
        }
        Ok(self.describer().describe(hand))
    }

    /// How the index's descriptors were made.
    pub fn descriptor_model(&self) -> DescriptorModel {
        DescriptorModel::of_index(self.catalogue().descriptor, self.file.network.clone())
    }

    /// Describes hand images as the index's own were: for many pictures. Where the index holds raw
    /// vectors, it describes them as zeros.
    pub fn describer(&self) -> Describer {
        self.descriptor_model().describer()
    }

    /// Whether the index can recognise what a picture shows. Searching it for descriptors is always
    /// possible.
    ///
    /// # Errors
    /// [`CannotRecognise`] says what it lacks.
    pub fn check_recognises(&self) -> Result<(), CannotRecognise> {
        if !self.catalogue().descriptor.describes_pictures() {
            return Err(CannotRecognise::RawDescriptors);
        }
        if !self.catalogue().kept.labels {
            return Err(CannotRecognise::NoLabels);
        }
        Ok(())
    }

    /// A search for as many neighbours as the index was calibrated with.
    pub fn search_options(&self) -> SearchOptions {
        SearchOptions { k: self.catalogue().calibration.k as usize, ..SearchOptions::default() }
    }

    /// Searches the index, query after query.
    pub fn searcher(&self) -> Searcher<'_> {
        let files: Vec<&dyn ReadAhead> = vec![self.bytes()];
        Searcher::new(self.stored(), &self.hash(), &self.catalogue().measured, files, self.was_cold())
    }

    pub(crate) fn bytes(&self) -> &Bytes {
        &self.file.bytes
    }

    /// Whether no search has been made yet; from now on one has.
    pub(crate) fn was_cold(&self) -> bool {
        self.is_cold.swap(false, Ordering::Relaxed)
    }

    pub(crate) fn hash(&self) -> Hash<'_> {
        match self.catalogue().hash {
            HashInfo::Random(size) => Hash::Random(Random {
                hyperplanes: RandomHyperplanes {
                    size,
                    dim: self.dim(),
                    normals: self.file.plane_normals(),
                    offsets: self.file.plane_offsets(),
                },
                files: vec![random::Entries {
                    buckets: Buckets { directory: self.file.bucket_directory(), ids: self.file.bucket_ids() },
                    count: self.len(),
                    first: 0,
                }],
            }),
            HashInfo::Learned(size) => Hash::Learned(self.learned(size)),
        }
    }

    fn learned(&self, size: LearnedHash) -> Learned<'_> {
        let axes = size.axes as usize;
        Learned {
            axes: Axes { count: axes, projection: self.file.axes() },
            centres: Centres {
                scale: size.centre_scale,
                groups: self.file.group_centres(axes),
                group_directory: self.file.group_directory(),
                buckets: self.file.bucket_centres(axes),
            },
            residual_scale: size.residual_scale,
            files: vec![learned::Entries {
                directory: self.file.bucket_directory(),
                blocks: self.file.entry_blocks(axes),
            }],
        }
    }

    /// The steps of a search by a learned hash, for each of the machine's instruction sets, fastest first. For benches.
    #[cfg(feature = "parts")]
    #[doc(hidden)]
    pub fn parts(&self) -> Vec<crate::search::parts::Parts<'_>> {
        let HashInfo::Learned(size) = self.catalogue().hash else {
            return Vec::new();
        };
        let part = |simd| crate::search::parts::Parts::new(self.stored(), self.learned(size), simd);
        crate::search::simd::Simd::available().into_iter().map(part).collect()
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
        self.vote_of_looks(&[Look { neighbours, opinion: None, turn_deg: 0.0 }], options)
    }

    /// What the neighbours of several looks at one picture say together: a class's probability is
    /// the mean of the looks' own, and all neighbours of the first class make the orientation. The
    /// opinion of a look counts as much as its neighbours do, where the index has the classes that
    /// networks are trained on, Cutkosky's 1, 2, 4, 9, 10 and 12.
    pub fn vote_of_looks(&self, looks: &[Look<'_>], options: &VoteOptions) -> Vote {
        let catalogue = self.catalogue();
        let fitted = catalogue.calibration.sigma_scale * catalogue.sigma.mean_distance;
        let sigma = match (options.sigma, options.sigma_scale) {
            (Some(sigma), _) => sigma,
            (None, Some(scale)) => scale * catalogue.sigma.mean_distance,
            (None, None) if options.literal_sigma => catalogue.sigma.literal,
            (None, None) => fitted,
        };
        let count = catalogue.classes.len();
        let trained_on = catalogue.classes.iter().map(|class| class.cutkosky).eq(NETWORK_CLASSES);
        let has_opinions = trained_on && !options.has_own_width();
        let each = 1.0 / looks.len().max(1) as f64;
        let (mut shares, mut probabilities) = (vec![0.0; count], vec![0.0; count]);
        let (mut kernel_mass, mut ballots, mut stages) = (0.0, Vec::new(), None);
        for look in looks {
            let own: Vec<Ballot> = look.neighbours.iter().filter_map(|n| self.ballot(n)).collect();
            let voters = own.iter().map(|ballot| (ballot.class, ballot.distance));
            let of_look = vote::shares(voters, count, sigma);
            // Another width than the calibrated one makes other shares.
            let probable = match options.has_own_width() {
                true => of_look.clone(),
                false => catalogue.calibration.probabilities(&of_look),
            };
            let opinion = look.opinion.filter(|opinion| has_opinions && opinion.classes.len() == count);
            let probable = match opinion {
                Some(opinion) => probable.iter().zip(&opinion.classes).map(|(a, b)| 0.5 * (a + b)).collect(),
                None => probable,
            };
            if let Some(opinion) = opinion {
                let stages = stages.get_or_insert([0.0; NETWORK_STAGES.len()]);
                stages.iter_mut().zip(opinion.stages).for_each(|(sum, own)| *sum += each * own);
            }
            shares.iter_mut().zip(of_look).for_each(|(sum, share)| *sum += each * share);
            probabilities.iter_mut().zip(probable).for_each(|(sum, own)| *sum += each * own);
            kernel_mass += each * vote::kernel_mass(own.iter().map(|ballot| ballot.distance), sigma);
            ballots.extend(own.into_iter().map(|ballot| ballot.turned(-look.turn_deg)));
        }
        if looks.len() > 1 && !options.has_own_width() {
            vote::sharpen(&mut probabilities);
        }
        let scores = (0u16..).zip(&catalogue.classes).zip(shares.into_iter().zip(probabilities));
        let mut classes: Vec<ClassScore> = scores
            .map(|((class, info), (share, probability))| ClassScore {
                class,
                name: info.name.clone(),
                cutkosky: info.cutkosky,
                probability,
                share,
            })
            .collect();
        // Stable: equals stay in the order of their numbers.
        classes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let first = classes.first().map_or(0, |score| score.class);
        let orientation = vote::estimate(&ballots, first, sigma, options.euler_mean);
        Vote { classes, stages, kernel_mass, orientation }
    }

    fn ballot(&self, neighbour: &Neighbour) -> Option<Ballot> {
        let class = *self.labels().get(neighbour.id as usize)?;
        let orientation = match self.catalogue().kept.orientations {
            true => Some(self.orientation(neighbour.id)?),
            false => None,
        };
        let distance = f64::from(neighbour.distance);
        let counts = (class as usize) < self.catalogue().classes.len() && distance.is_finite();
        counts.then_some(Ballot { class, distance, orientation })
    }

    /// Everything about an entry besides its descriptor and thumbnail.
    ///
    /// # Errors
    /// [`EntryError`], when there is no such entry or the file says something about it that makes no sense.
    pub fn entry(&self, id: u32) -> Result<Entry<'_>, EntryError> {
        if id as usize >= self.len() {
            return Err(EntryError::NoSuchEntry { id, entries: self.len() });
        }
        let kept = self.catalogue().kept;
        let (class, [hand_shape, stage, object]) = match kept.labels {
            true => self.named(id).map(|(class, names)| (Some(class), names))?,
            false => (None, [""; 3]),
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
            file: if kept.files { file().ok_or(corrupt("file name"))? } else { "" },
            hand_shape,
            stage,
            object,
            view_deg: kept.views.then(view).transpose()?,
            orientation: kept.orientations.then(orientation).transpose()?,
        })
    }

    /// An entry as it went into the index, so that it can go into another: written with the same names and parameters, what is kept of
    /// it has the same bytes again. The descriptor is as exact as [`Catalogue::originals`] says; the class, the hand shape and the
    /// stage are this index's numbers.
    ///
    /// # Errors
    /// [`EntryError`], when there is no such entry, the index keeps no descriptors, or the file says something about the entry that
    /// makes no sense.
    pub fn new_entry(&self, id: u32) -> Result<NewEntry, EntryError> {
        let entry = self.entry(id)?;
        let corrupt = |what| EntryError::Corrupt { id, what };
        let descriptor = self.descriptor(id).ok_or(corrupt("descriptor"))?.into_owned();
        let [azimuth_deg, elevation_deg, roll_deg] = entry.view_deg.unwrap_or_default();
        let orientations = self.file.orientations();
        let orientation = orientations.get(id as usize).copied().and_then(pack::unpack_as_packed);
        Ok(NewEntry {
            class: entry.class.unwrap_or_default(),
            stage: self.file.stages().get(id as usize).copied().unwrap_or_default(),
            hand_shape: self.file.hand_shapes().get(id as usize).copied().unwrap_or_default(),
            object: entry.object.to_owned(),
            file: entry.file.to_owned(),
            azimuth_deg,
            elevation_deg,
            roll_deg,
            orientation: orientation.unwrap_or_default(),
            source_hash: self.source_hashes().get(id as usize).copied().unwrap_or_default(),
            descriptor,
            thumbnail: self.thumbnail(id).map(<[u8]>::to_vec),
        })
    }

    /// The class of an entry, and the names of its hand shape, stage and object.
    fn named(&self, id: u32) -> Result<(u16, [&str; 3]), EntryError> {
        let (at, catalogue) = (id as usize, self.catalogue());
        let corrupt = |what| EntryError::Corrupt { id, what };
        let class = self.labels().get(at).filter(|&&class| usize::from(class) < catalogue.classes.len());
        let hand_shape =
            self.file.hand_shapes().get(at).and_then(|&hand| catalogue.hand_shapes.get(usize::from(hand)));
        let stage = self.file.stages().get(at).and_then(|&stage| catalogue.stages.get(usize::from(stage)));
        let object = self.file.objects().get(at).copied();
        let object = object.and_then(|object| self.file.object_name(usize::from(object)));
        let class = *class.ok_or(corrupt("class"))?;
        let names = [
            hand_shape.ok_or(corrupt("hand shape"))?.as_str(),
            stage.ok_or(corrupt("stage"))?.as_str(),
            object.ok_or(corrupt("object"))?,
        ];
        Ok((class, names))
    }

    /// `camera_from_hand`; `None` where there is no such entry or what the file has is no rotation.
    fn orientation(&self, id: u32) -> Option<UnitQuaternion<f64>> {
        let orientations = self.file.orientations();
        pack::unpack_rotation(*orientations.get(id as usize)?)
    }

    /// The picture of an entry: [`Catalogue::thumbnail_side`] squared grey values, row-major. `None` where it has none.
    pub fn thumbnail(&self, id: u32) -> Option<&[u8]> {
        let pixels = (self.catalogue().thumbnail_side as usize).pow(2);
        let start = (id as usize).checked_mul(pixels)?;
        let end = start.checked_add(pixels)?;
        let thumbnail = self.file.thumbnails().get(start..end)?;
        thumbnail.iter().any(|&grey| grey != 0).then_some(thumbnail)
    }

    /// The descriptor of an entry, as exactly as [`Catalogue::originals`] says; `None` where there is no such entry, or
    /// descriptors are not kept.
    pub fn descriptor(&self, id: u32) -> Option<Cow<'_, [f32]>> {
        self.stored().get(id)
    }

    /// The class of each entry, in the order of their numbers; nothing where the index keeps no labels.
    pub fn labels(&self) -> &[u16] {
        self.file.labels()
    }

    /// The hash, for each entry, of what its descriptor was made from: a rebuild may take over the descriptor of an entry
    /// with the same hash, if [`Self::params_hash`] has not changed either. Nothing where the index keeps none.
    pub fn source_hashes(&self) -> &[u64] {
        self.file.source_hashes()
    }

    /// [`crate::DescriptorParams::fingerprint`] of the index's descriptors.
    pub fn params_hash(&self) -> u64 {
        self.catalogue().descriptor_fingerprint
    }

    pub(crate) fn stored(&self) -> Stored<'_> {
        Stored { dim: self.dim(), entries: self.len(), values: self.file.descriptors() }
    }
}
