//! Verifying: every byte of the file is hashed or known to be zero, and what the arrays say is
//! checked for sense.

use super::header::LENGTH;
use super::open::Opened;
use super::pack;
use super::sections::SectionKind;
use crate::search::blocks::LANES;
use crate::search::hash::HashInfo;
use crate::search::stored::Values;
use rayon::prelude::*;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// What verifying an index found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verification {
    /// How many bytes were checked: all of the file.
    pub bytes: u64,
    /// What is wrong; nothing where the index is sound.
    pub problems: Vec<Problem>,
}

impl Verification {
    /// Whether the index is sound.
    pub fn is_sound(&self) -> bool {
        self.problems.is_empty()
    }
}

/// Something wrong in an index.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// Bytes have changed since the index was written.
    #[error("corrupt: the section {0:?} does not match its hash: copy or build the file again")]
    Hash(SectionKind),
    /// Bytes between two sections have changed.
    #[error(
        "corrupt: bytes {start} to {end}, between two sections, are not zero: copy or build the file again"
    )]
    Padding {
        /// The first byte of the gap.
        start: u64,
        /// The byte after its last.
        end: u64,
    },
    /// An element makes no sense, although the hash is right: the file was written by something
    /// else.
    #[error("element {at} of the section {kind:?} {what}: build the file again")]
    Element {
        /// The section.
        kind: SectionKind,
        /// Which element, counted from 0; of texts which text, of blocks of entries which place, or
        /// which entry where it is in no bucket.
        at: usize,
        /// What is wrong with it.
        what: &'static str,
    },
}

/// Checks all that opening did not.
pub(crate) fn verify(file: &Opened) -> Verification {
    let mut problems = padding(file);
    let sections = file.catalogue.sections.par_iter();
    let changed = sections.filter(|section| xxh3_64(file.raw(section.kind)) != section.xxh3);
    problems.extend(changed.map(|section| Problem::Hash(section.kind)).collect::<Vec<_>>());
    if problems.is_empty() {
        problems.extend(elements(file));
    }
    Verification { bytes: file.bytes.len() as u64, problems }
}

/// The gaps between the header, the sections and the catalogue.
fn padding(file: &Opened) -> Vec<Problem> {
    let starts = file.catalogue.sections.iter().map(|section| section.offset);
    let starts = starts.chain([file.header.catalogue_offset]);
    let ends = file.catalogue.sections.iter().map(|section| section.offset + section.length);
    let gaps = [LENGTH as u64].into_iter().chain(ends).zip(starts);
    let is_clean = |&(start, end): &(u64, u64)| {
        file.bytes.get(start as usize..end as usize).is_some_and(|gap| gap.iter().all(|&byte| byte == 0))
    };
    gaps.filter(|gap| !is_clean(gap)).map(|(start, end)| Problem::Padding { start, end }).collect()
}

/// The first senseless element of each section.
fn elements(file: &Opened) -> Vec<Problem> {
    use SectionKind::*;
    let catalogue = &file.catalogue;
    let below = |limit: usize| move |value: usize| value < limit;
    let (entries, kept) = (catalogue.entries as usize, &catalogue.kept);
    let finite = |value: &f32| value.is_finite();
    let classes = catalogue.classes.len();
    let found = [
        descriptors(file),
        first(Views, file.views().as_flattened(), "is no angle", |&angle| angle < pack::TURN),
        first(PlaneNormals, file.plane_normals(), "is not a finite number", finite),
        first(PlaneOffsets, file.plane_offsets(), "is not a finite number", finite),
        first(Labels, file.labels(), "is no class", |&class| below(classes)(class.into())),
        first(Stages, file.stages(), "is no stage", |&stage| below(catalogue.stages.len())(stage.into())),
        first(HandShapes, file.hand_shapes(), "is no hand shape", |&hand| {
            below(catalogue.hand_shapes.len())(hand.into())
        }),
        first(Objects, file.objects(), "is no object", |&object| u32::from(object) < catalogue.objects),
        first(BucketIds, file.bucket_ids(), "is no entry", |&id| below(entries)(id as usize)),
        first(Orientations, file.orientations(), "is no unit quaternion", |&packed| {
            pack::unpack_rotation(packed).is_some()
        }),
        first(Axes, file.axes(), "is not a finite number", finite),
        buckets(file, entries),
        kept.files.then(|| file_names(file, entries)).flatten(),
        kept.labels.then(|| object_names(file, catalogue.objects as usize)).flatten(),
    ];
    found.into_iter().flatten().collect()
}

fn descriptors(file: &Opened) -> Option<Problem> {
    let (kind, what) = (SectionKind::Descriptors, "is not a finite number");
    match file.descriptors() {
        Values::F32(values) | Values::ToBeHalved(values) => {
            first(kind, values, what, |value| value.is_finite())
        }
        Values::F16(values) => first(kind, values, what, |value| value.is_finite()),
        Values::None | Values::Several(_) => None,
    }
}

/// The directories of the hash, and that a learned hash holds every entry once.
fn buckets(file: &Opened, entries: usize) -> Option<Problem> {
    let hash = match file.catalogue.hash {
        HashInfo::Random(_) => {
            let ids = file.bucket_ids().len();
            return ascending(SectionKind::BucketDirectory, file.bucket_directory(), ids);
        }
        HashInfo::Learned(hash) => hash,
    };
    let centre_blocks = hash.centre_blocks as usize;
    let directories =
        ascending(SectionKind::GroupDirectory, file.group_directory(), centre_blocks).or_else(|| {
            ascending(SectionKind::BucketDirectory, file.bucket_directory(), hash.entry_blocks as usize)
        });
    if directories.is_some() {
        return directories;
    }
    let mut met = vec![false; entries];
    let blocks = file.entry_blocks(&hash);
    let ids = blocks.iter().flat_map(|block| (0..LANES).map(move |lane| block.id(lane)));
    // A place without an entry has the id that no entry has.
    let mut is_good =
        |id: u32| id == u32::MAX || met.get_mut(id as usize).is_some_and(|met| !std::mem::replace(met, true));
    let at = ids.enumerate().find_map(|(at, id)| (!is_good(id)).then_some(at));
    if let Some(at) = at {
        return Some(Problem::Element {
            kind: SectionKind::EntryBlocks,
            at,
            what: "is no entry, or one that was met before",
        });
    }
    let at = met.iter().position(|met| !met)?;
    Some(Problem::Element { kind: SectionKind::EntryBlocks, at, what: "is in no bucket" })
}

fn first<T>(
    kind: SectionKind,
    elements: &[T],
    what: &'static str,
    is_good: impl Fn(&T) -> bool,
) -> Option<Problem> {
    let at = elements.iter().position(|element| !is_good(element))?;
    Some(Problem::Element { kind, at, what })
}

/// Offsets start at 0, never fall, and end at `end`.
fn ascending(kind: SectionKind, offsets: &[u32], end: usize) -> Option<Problem> {
    let falls = offsets.windows(2).position(|pair| matches!(pair, [a, b] if a > b)).map(|at| at + 1);
    let starts = offsets.first() == Some(&0);
    let ends = offsets.last().is_some_and(|&last| last as usize == end);
    let last = offsets.len().saturating_sub(1);
    let at = falls.or((!starts).then_some(0)).or((!ends).then_some(last))?;
    Some(Problem::Element { kind, at, what: "is no offset in ascending order" })
}

/// Texts are looked at where their offsets ascend alone: others may each be all of the text.
fn file_names(file: &Opened, entries: usize) -> Option<Problem> {
    let text = SectionKind::FileText;
    ascending(SectionKind::FileOffsets, file.file_offsets(), file.raw(text).len())
        .or_else(|| texts(text, entries, |at| file.file_name(at)))
}

fn object_names(file: &Opened, objects: usize) -> Option<Problem> {
    let text = SectionKind::ObjectText;
    ascending(SectionKind::ObjectOffsets, file.object_offsets(), file.raw(text).len())
        .or_else(|| texts(text, objects, |at| file.object_name(at)))
}

fn texts(kind: SectionKind, count: usize, text: impl Fn(usize) -> Option<String>) -> Option<Problem> {
    let at = (0..count).find(|&at| text(at).is_none())?;
    Some(Problem::Element { kind, at, what: "is no text" })
}

#[cfg(test)]
mod tests;
