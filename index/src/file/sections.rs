//! The sections: which there are, and what they hold.

use crate::descriptor::{DescriptorKind, DescriptorParams};
use crate::search::Originals;

/// Where a section lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section {
    /// What it holds.
    pub kind: SectionKind,
    /// The type of its elements.
    pub element: ElementType,
    /// Where it starts, in bytes from the start of the file: a multiple of 64.
    pub offset: u64,
    /// Its length in bytes.
    pub length: u64,
    /// xxh3 of its bytes.
    pub xxh3: u64,
}

/// The type of a section's elements, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementType {
    /// Bytes.
    U8,
    /// 16-bit integers.
    U16,
    /// 16-bit integers with a sign.
    I16,
    /// 32-bit integers.
    U32,
    /// 64-bit integers.
    U64,
    /// 16-bit floating-point numbers.
    F16,
    /// 32-bit floating-point numbers.
    F32,
}

impl ElementType {
    pub(crate) fn size(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::U64 => 8,
        }
    }
}

/// What a section holds. N is the number of entries, D the length of a descriptor. What an index
/// does not keep ([`super::kept::KeptFields`]) is a section of no length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionKind {
    /// N x D f32 or f16, or nothing: the descriptors.
    Descriptors,
    /// N u16: the classes.
    Labels,
    /// N u8: the stages.
    Stages,
    /// N u16: the hand shapes.
    HandShapes,
    /// N x 4 i16: `camera_from_hand`, quaternions x, y, z, w in units of 1/32767.
    Orientations,
    /// N x 3 u16: azimuth, elevation and roll in hundredths of a degree, modulo a full turn.
    Views,
    /// N u64: hashes of what the descriptors were made from.
    SourceHashes,
    /// N + 1 u32: where each entry's file name starts and ends.
    FileOffsets,
    /// UTF-8: the file names.
    FileText,
    /// N u16: the objects.
    Objects,
    /// objects + 1 u32: where each object's name starts and ends.
    ObjectOffsets,
    /// UTF-8: the objects' names.
    ObjectText,
    /// N x side x side u8, or nothing: thumbnails, all 0 where an entry has none.
    Thumbnails,
    /// T x K x D f32: the normals of random hyperplanes.
    PlaneNormals,
    /// T x K f32: the offsets of random hyperplanes.
    PlaneOffsets,
    /// Buckets + 1 u32: where each bucket starts and ends, in ids (T x H buckets of a random hash)
    /// or in blocks.
    BucketDirectory,
    /// T x N u32: the ids in the buckets of a random hash.
    BucketIds,
    /// (D + 1) x P f32: what each value of a vector adds to its coordinates in the principal axes,
    /// and their offsets.
    Axes,
    /// Blocks of sixteen: the centres of a learned hash's groups.
    GroupCentres,
    /// Groups + 1 u32: where the blocks of each group's centres start and end.
    GroupDirectory,
    /// Blocks of sixteen: the centres of a learned hash's buckets.
    BucketCentres,
    /// Blocks of sixteen: the entries in the buckets of a learned hash.
    EntryBlocks,
    /// The bytes of the network behind a learned descriptor; only there where the descriptor is
    /// one.
    Network,
}

impl SectionKind {
    /// All sections, in the order of the file: descriptors first, because they are written first;
    /// what every search touches lies last, together.
    pub(crate) const ALL: [Self; 23] = [
        Self::Descriptors,
        Self::Thumbnails,
        Self::FileOffsets,
        Self::FileText,
        Self::ObjectOffsets,
        Self::ObjectText,
        Self::Objects,
        Self::SourceHashes,
        Self::Views,
        Self::Stages,
        Self::HandShapes,
        Self::Labels,
        Self::Orientations,
        Self::BucketIds,
        Self::EntryBlocks,
        Self::BucketDirectory,
        Self::PlaneOffsets,
        Self::PlaneNormals,
        Self::BucketCentres,
        Self::GroupDirectory,
        Self::GroupCentres,
        Self::Axes,
        Self::Network,
    ];

    /// The sections of an index whose descriptors are such, in the order of the file. What came
    /// with learned descriptors is not in others, which older readers read.
    pub(crate) fn of(descriptor: &DescriptorParams) -> &'static [Self] {
        match descriptor.kind {
            DescriptorKind::Learned { .. } => &Self::ALL,
            _ => Self::ALL.split_last().map_or(&[], |(_, rest)| rest),
        }
    }

    /// Whether the hash, and not the entries, make the section.
    pub(crate) fn is_of_the_hash(self) -> bool {
        matches!(
            self,
            Self::PlaneNormals
                | Self::PlaneOffsets
                | Self::BucketDirectory
                | Self::BucketIds
                | Self::Axes
                | Self::GroupCentres
                | Self::GroupDirectory
                | Self::BucketCentres
                | Self::EntryBlocks
        )
    }

    /// Whether the section was learned from all entries together: what is left of the hash where
    /// one has no entries.
    pub(crate) fn is_learned(self) -> bool {
        self.is_of_the_hash() && !matches!(self, Self::BucketDirectory | Self::BucketIds | Self::EntryBlocks)
    }

    /// The type of the section's elements in an index that keeps `originals`.
    pub(crate) fn element(self, originals: Originals) -> ElementType {
        match self {
            Self::Descriptors if originals == Originals::F16 => ElementType::F16,
            Self::Stages
            | Self::FileText
            | Self::ObjectText
            | Self::Thumbnails
            | Self::GroupCentres
            | Self::BucketCentres
            | Self::EntryBlocks
            | Self::Network => ElementType::U8,
            Self::Labels | Self::HandShapes | Self::Objects | Self::Views => ElementType::U16,
            Self::Orientations => ElementType::I16,
            Self::FileOffsets
            | Self::ObjectOffsets
            | Self::BucketDirectory
            | Self::GroupDirectory
            | Self::BucketIds => ElementType::U32,
            Self::SourceHashes => ElementType::U64,
            Self::Descriptors | Self::PlaneNormals | Self::PlaneOffsets | Self::Axes => ElementType::F32,
        }
    }
}
