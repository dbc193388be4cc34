//! Recognises the grasp of a hand in a picture by its nearest neighbours among many known pictures,
//! over one memory-mapped file.
//!
//! The method is H. Kjellström, J. Romero and D. Kragić, *Visual Recognition of Grasps for
//! Human-to-Robot Mapping* (IROS 2008), Sections IV and V. In order of the data:
//!
//! 1. [`HandImage`]: the hand, cut out of a grey picture.
//! 2. [`Index::describe`]: its descriptor, one vector: a pyramid of histograms of gradient
//!    orientation ([`DescriptorParams`]), or what a network makes of the hand, which then lies in
//!    the index ([`DescriptorModel`]).
//! 3. [`Index::search`]: the k nearest descriptors of the index, by locality-sensitive hashing. The
//!    hash says which of its buckets are the most promising. Of the entries in the first of them,
//!    short codes are compared; the distances of the best few are measured, and the k nearest kept.
//!    [`Effort`] says how much of what is nearest shall be found: how many buckets do that, the
//!    index has measured ([`Measured`]).
//! 4. [`Index::vote`]: the class and the orientation, from the labels of those neighbours, each
//!    weighed by its distance; [`Calibration`] makes probabilities of the weights.
//!
//! [`IndexWriter`] makes the file. It takes entries one by one, and when all are in, it learns of
//! them what the steps above go by: the width of the weights ([`Sigma`]), the hash (hyperplanes
//! that are fitted to the data, or the paper's random ones: [`HashParams`]), what each effort finds
//! and what the neighbours' agreement is worth. [`Index::open`] maps the file; [`Segments`]
//! searches several as one. Where another program may copy a file over one that is mapped, call
//! [`guard_against_truncation`] first and ask [`Index::check_unchanged`] after each answer.
//!
//! ```
//! use grasp_index::*;
//! use nalgebra::UnitQuaternion;
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("grasp.idx");
//! // A "hand" that points up or sideways, a little differently each time.
//! let picture = |class: u16, n: usize| {
//!     let mut grey = vec![0u8; 64 * 64];
//!     for (long, across) in (8..56).flat_map(|long| (26..36 + n % 7).map(move |across| (long, across))) {
//!         let at = if class == 0 { long * 64 + across } else { across * 64 + long };
//!         grey[at] = 90 + (long * n % 50) as u8;
//!     }
//!     HandImage::from_segmented(64, 64, &grey, 0).unwrap()
//! };
//!
//! let class = |name: &str, cutkosky| ClassInfo { name: name.into(), cutkosky };
//! let mut writer = IndexWriter::create(&path, IndexParams {
//!     classes: vec![class("large-diameter", 1), class("pinch", 9)],
//!     hand_shapes: vec!["mean".into()],
//!     stages: vec!["grasp".into()],
//!     ..IndexParams::default()
//! })?;
//! let params = DescriptorParams::default();
//! for n in 0..40 {
//!     writer.push(NewEntry {
//!         class: n as u16 % 2,
//!         file: format!("{n}.png"),
//!         descriptor: params.describe(&picture(n as u16 % 2, n))?,
//!         ..NewEntry::default()
//!     })?;
//! }
//! writer.finish(&|_phase, _share| std::ops::ControlFlow::Continue(()))?;
//!
//! let index = Index::open(&path)?;
//! let query = index.describe(&picture(1, 100))?;
//! let found = index.search(&query, &SearchOptions::default())?;
//! let vote = index.vote(&found.neighbours, &VoteOptions::default());
//! assert_eq!(vote.classes[0].name, "pinch");
//! assert!(vote.orientation.rotation.angle_to(&UnitQuaternion::identity()) < 1e-6);
//! println!("{} of {} entries were looked at", found.cost.candidates, index.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod descriptor;
mod entry;
mod file;
mod hand_image;
mod index;
mod index_vote;
mod model;
pub mod npy;
mod phase;
mod resample;
mod rotation;
mod search;
mod segments;
mod vote;

pub use descriptor::{
    Cell, Describer, DescriptorKind, DescriptorModel, DescriptorParams, NETWORK_STAGES, NetworkEstimate,
    PLANES_SIDE, PLANES_SOURCE_SIDE, ParamsError, Placement, SHOWN_LENGTHS, Sampling, Tone, planes, shown,
};
pub use entry::{Entry, EntryError};
pub use file::atomic::{AtomicFile, WriteError};
pub use file::catalogue::{Catalogue, ClassInfo};
pub use file::corruption::Corruption;
pub use file::error::{FileChanged, OpenError};
pub use file::fault::guard_against_truncation;
pub use file::input::{BuildError, EntryFault, IndexParams, NewEntry, Summary};
pub use file::kept::KeptFields;
pub use file::sections::{ElementType, Section, SectionKind};
pub use file::verify::{Problem, Verification};
pub use file::write::IndexWriter;
pub use grasp_network::Network;
pub use hand_image::upright::end_of_hand;
pub use hand_image::{BACKGROUND, DESCRIBED_SIDE, HandImage, HandImageError, MIN_SIDE};
pub use index::{CannotRecognise, Index};
pub use phase::Phase;
pub use rotation::{euler_deg, from_columns, from_euler_deg, mirror_orientation, turned_orientation};
pub use search::blocks::CodeBits;
pub use search::build::{HashParams, RandomParams};
pub use search::effort::{EPS, EPS_GRID, EffortPoint, Measured};
pub use search::hash::HashInfo;
pub use search::learned::LearnedHash;
#[cfg(feature = "parts")]
#[doc(hidden)]
pub use search::parts::Parts;
pub use search::queries::{NOISE, moved_along};
pub use search::random::RandomHash;
pub use search::searcher::Searcher;

pub use search::{Effort, Neighbour, Originals, Search, SearchCost, SearchError, SearchOptions, Shortlist};
pub use segments::{Segments, SegmentsError, SegmentsSearcher};
pub use vote::{
    Calibrated, Calibration, ClassScore, Doubt, Look, OrientationEstimate, Reliability, ReliabilityBin,
    Sigma, Vote, VoteOptions, mean_distance, mean_rotation,
};

/// The version of the index format that this crate writes, and the newest that it reads.
pub const FORMAT_VERSION: u32 = file::header::VERSION;
