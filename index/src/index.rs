//! An opened index.

use crate::descriptor::{Describer, DescriptorModel};
use crate::file::atomic::AtomicFile;
use crate::file::bytes::Bytes;
use crate::file::catalogue::Catalogue;
use crate::file::error::FileChanged;
use crate::file::error::OpenError;
use crate::file::input::BuildError;
use crate::file::open::Opened;
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
use crate::search::{Hash, ReadAhead, Search, SearchError, SearchOptions};
use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// An index, opened for searching. It can be shared between threads.
#[derive(Debug)]
pub struct Index {
    pub(crate) file: Opened,
    /// No search has been made yet, and the pages that one needs may have to come from the disk.
    is_cold: AtomicBool,
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
    /// Opens an index by mapping its file: in a time that does not depend on its size. The file
    /// should not be changed or truncated meanwhile (replacing it by renaming, as
    /// [`crate::IndexWriter`] does, is no change): [`Self::check_unchanged`] says whether it was,
    /// and [`crate::guard_against_truncation`] keeps the process alive where it is. What
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

    /// Opens an index that is in memory already, such as one compiled into a program. The bytes are
    /// copied.
    ///
    /// # Errors
    /// [`OpenError`], when they are no sound index.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OpenError> {
        Self::new(Bytes::copy(bytes))
    }

    fn new(bytes: Bytes) -> Result<Self, OpenError> {
        Ok(Self { file: Opened::new(bytes)?, is_cold: AtomicBool::new(true) })
    }

    /// Whether everything that this index has said until now was read from one and the same file.
    /// Where another program has overwritten or truncated the file that is mapped, answers may be
    /// wrong, and the index is never whole again: open the file anew. An index in memory cannot
    /// change. Costs one system call (0.3 us): ask after each answer, or after many.
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
    /// [`BuildError`], where there are no such entries, the index is damaged or the file cannot be
    /// written; what was at its place is then as it was.
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
        Searcher::new(self.stored(), &self.hash(), &self.catalogue().measured, files, vec![&self.is_cold])
    }

    pub(crate) fn bytes(&self) -> &Bytes {
        &self.file.bytes
    }

    /// Whether no search has been made yet.
    pub(crate) fn is_cold(&self) -> &AtomicBool {
        &self.is_cold
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
                blocks: self.file.entry_blocks(&size),
            }],
        }
    }

    /// The steps of a search by a learned hash, for each of the machine's instruction sets, fastest
    /// first. For benches.
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

    /// The class of each entry, in the order of their numbers; nothing where the index keeps no
    /// labels.
    pub fn labels(&self) -> &[u16] {
        self.file.labels()
    }

    /// The hash, for each entry, of what its descriptor was made from: a rebuild may take over the
    /// descriptor of an entry with the same hash, if [`Self::params_hash`] has not changed either.
    /// Nothing where the index keeps none.
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
