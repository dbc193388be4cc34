//! What the sections hold, each as what it is.

use super::open::Opened;
use super::sections::{ElementType, SectionKind};
use crate::search::Originals;
use crate::search::blocks::Blocks;
use crate::search::learned::LearnedHash;
use crate::search::stored::Values;
use bytemuck::AnyBitPattern;
use half::f16;

/// What a section may be an array of.
trait Element: AnyBitPattern {
    const TYPE: ElementType;
}

impl Element for u8 {
    const TYPE: ElementType = ElementType::U8;
}

impl Element for u16 {
    const TYPE: ElementType = ElementType::U16;
}

impl Element for [u16; 3] {
    const TYPE: ElementType = ElementType::U16;
}

impl Element for [i16; 4] {
    const TYPE: ElementType = ElementType::I16;
}

impl Element for u32 {
    const TYPE: ElementType = ElementType::U32;
}

impl Element for u64 {
    const TYPE: ElementType = ElementType::U64;
}

impl Element for f16 {
    const TYPE: ElementType = ElementType::F16;
}

impl Element for f32 {
    const TYPE: ElementType = ElementType::F32;
}

/// Accessors of sections that are plain arrays.
macro_rules! arrays {
    ($($name:ident: $element:ty = $kind:ident;)*) => {
        impl Opened {
            $(pub(crate) fn $name(&self) -> &[$element] {
                self.array(SectionKind::$kind)
            })*
        }
    };
}

arrays! {
    labels: u16 = Labels;
    stages: u8 = Stages;
    hand_shapes: u16 = HandShapes;
    objects: u16 = Objects;
    orientations: [i16; 4] = Orientations;
    views: [u16; 3] = Views;
    source_hashes: u64 = SourceHashes;
    file_offsets: u32 = FileOffsets;
    object_offsets: u32 = ObjectOffsets;
    thumbnails: u8 = Thumbnails;
    plane_normals: f32 = PlaneNormals;
    plane_offsets: f32 = PlaneOffsets;
    bucket_directory: u32 = BucketDirectory;
    bucket_ids: u32 = BucketIds;
    axes: f32 = Axes;
    group_directory: u32 = GroupDirectory;
}

impl Opened {
    fn array<T: Element>(&self, kind: SectionKind) -> &[T] {
        debug_assert_eq!(T::TYPE, kind.element(self.catalogue.originals), "{kind:?}");
        // Opening has checked that the section starts at a multiple of 64 and is an integer number
        // of elements long.
        bytemuck::try_cast_slice(self.raw(kind)).unwrap_or(&[])
    }

    /// The descriptors, in the form in which they are kept.
    pub(crate) fn descriptors(&self) -> Values<'_> {
        match self.catalogue.originals {
            Originals::F32 => Values::F32(self.array(SectionKind::Descriptors)),
            Originals::F16 => Values::F16(self.array(SectionKind::Descriptors)),
            Originals::None => Values::None,
        }
    }

    /// The centres of a learned hash's groups.
    pub(crate) fn group_centres(&self, axes: usize) -> Blocks<'_> {
        Blocks::of_centres(self.raw(SectionKind::GroupCentres), axes)
    }

    /// The centres of a learned hash's buckets.
    pub(crate) fn bucket_centres(&self, axes: usize) -> Blocks<'_> {
        Blocks::of_centres(self.raw(SectionKind::BucketCentres), axes)
    }

    /// The entries in the buckets of a learned hash.
    pub(crate) fn entry_blocks(&self, hash: &LearnedHash) -> Blocks<'_> {
        Blocks::of_entries(self.raw(SectionKind::EntryBlocks), hash.axes as usize, hash.code_bits)
    }

    /// The file name of an entry; `None` where the bounds make no sense or the bytes are no text.
    pub(crate) fn file_name(&self, entry: usize) -> Option<String> {
        text(self.file_offsets(), self.raw(SectionKind::FileText), entry)
    }

    /// The name of an object; `None` as above.
    pub(crate) fn object_name(&self, object: usize) -> Option<String> {
        text(self.object_offsets(), self.raw(SectionKind::ObjectText), object)
    }
}

/// String `at` of a table of text: a copy, for what lies in a mapped file may be changed once it
/// has been checked.
fn text(offsets: &[u32], text: &[u8], at: usize) -> Option<String> {
    let (start, end) = (*offsets.get(at)?, *offsets.get(at.checked_add(1)?)?);
    String::from_utf8(text.get(start as usize..end as usize)?.to_vec()).ok()
}
