//! What another writer might get wrong: every hash is right, and an element makes no sense.

use super::*;
use crate::file::bytes::Bytes;
use crate::file::input::{IndexParams, NewEntry};
use crate::search::blocks::entry_stride;
use crate::search::build::{HashParams, RandomParams};
use crate::{ClassInfo, IndexWriter, Originals};
use half::f16;
use proptest::prelude::*;

const ENTRIES: u32 = 8;

/// A sound file of two objects; the last entry has no name.
fn sound(hash: HashParams, originals: Originals) -> Vec<u8> {
    let params = IndexParams {
        classes: vec![ClassInfo { name: "one".into(), cutkosky: 1 }],
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        hash,
        originals,
        ..IndexParams::default()
    };
    let dim = params.descriptor.dim();
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..ENTRIES {
        let descriptor = (0..dim).map(|at| n as f32 * 0.1 + (at % 7) as f32).collect();
        let file = if n + 1 < ENTRIES { format!("{n}.png") } else { String::new() };
        let object = ["ball", "rod"][n as usize % 2].into();
        writer.push(NewEntry { object, file, descriptor, ..NewEntry::default() }).expect("the entry fits");
    }
    writer.finish_bytes().expect("the index is built")
}

fn random() -> Vec<u8> {
    sound(HashParams::Random(RandomParams::Fixed { k: 2, t: 2, buckets: 4 }), Originals::F32)
}

fn learned() -> Vec<u8> {
    sound(HashParams::Learned, Originals::F16)
}

/// The file with some bytes of a section changed, and all hashes as they should be.
fn with(file: &[u8], kind: SectionKind, at: usize, value: &[u8]) -> Opened {
    let open = |file: &[u8]| Opened::new(Bytes::copy(file)).expect("opening reads no section");
    let sections = open(file).catalogue.sections;
    let section = sections.iter().find(|section| section.kind == kind).expect("there is such a section");
    let mut file = file.to_vec();
    file[section.offset as usize..][..section.length as usize][at..at + value.len()].copy_from_slice(value);
    let mut opened = open(&file);
    let hashes: Vec<u64> = sections.iter().map(|section| xxh3_64(opened.raw(section.kind))).collect();
    opened.catalogue.sections.iter_mut().zip(hashes).for_each(|(section, hash)| section.xxh3 = hash);
    opened
}

/// The one element that is found, after the bytes at it were changed.
fn assert_found(file: &[u8], kind: SectionKind, element: usize, value: &[u8]) {
    let problems = verify(&with(file, kind, element * value.len(), value)).problems;
    let is_found = matches!(problems.as_slice(),
        [Problem::Element { kind: found, at, .. }] if (*found, *at) == (kind, element));
    assert!(is_found, "element {element} of {kind:?}: {problems:?}");
}

#[test]
fn the_files_are_sound() {
    for file in [random(), learned()] {
        assert_eq!(verify(&with(&file, SectionKind::Stages, 0, &[0])).problems, []);
    }
}

#[test]
fn values_that_are_no_numbers_are_found() {
    use SectionKind::*;
    let (random, learned) = (random(), learned());
    for value in [f32::NAN, f32::INFINITY] {
        for (file, kind) in
            [(&random, Descriptors), (&random, PlaneNormals), (&random, PlaneOffsets), (&learned, Axes)]
        {
            assert_found(file, kind, 3, &value.to_le_bytes());
        }
        assert_found(&learned, Descriptors, 3, &f16::from_f32(value).to_le_bytes());
    }
}

#[test]
fn buckets_of_what_is_no_entry_are_found() {
    let file = random();
    assert_found(&file, SectionKind::BucketIds, 5, &ENTRIES.to_le_bytes());
}

proptest! {
    #[test]
    fn offsets_start_at_0_never_fall_and_end_with_what_they_are_of(
        offsets in prop::collection::vec(0..3u32, 0..5), end in 0..3usize
    ) {
        let is_sound =
            offsets.first() == Some(&0) && offsets.is_sorted() && offsets.last() == Some(&(end as u32));
        let found = ascending(SectionKind::FileOffsets, &offsets, end);
        prop_assert_eq!(found.is_none(), is_sound, "{:?}", found);
    }
}

#[test]
fn offsets_that_end_elsewhere_are_found() {
    use SectionKind::*;
    let (random, learned) = (random(), learned());
    for (file, kind) in [
        (&random, FileOffsets),
        (&random, ObjectOffsets),
        (&random, BucketDirectory),
        (&learned, BucketDirectory),
        (&learned, GroupDirectory),
    ] {
        let whole = with(file, Stages, 0, &[0]);
        let last = whole.raw(kind).len() / 4 - 1;
        let end = u32::from_le_bytes(*whole.raw(kind).last_chunk().expect("it is not empty"));
        // One past the end, and one before.
        assert_found(file, kind, last, &(end + 1).to_le_bytes());
        assert_found(file, kind, last, &(end - 1).to_le_bytes());
    }
}

#[test]
fn bytes_that_are_no_text_are_found() {
    use SectionKind::*;
    // Of the second name, whatever byte it is.
    let file = random();
    for (kind, second) in [(FileText, "0.png".len()), (ObjectText, "ball".len())] {
        let problems = verify(&with(&file, kind, second + 1, &[0xff])).problems;
        assert_eq!(problems, [Problem::Element { kind, at: 1, what: "is no text" }]);
    }
}

/// A learned hash holds every entry once.
#[test]
fn entries_that_no_bucket_or_two_have_are_found() {
    let file = learned();
    let opened = with(&file, SectionKind::Stages, 0, &[0]);
    let HashInfo::Learned(hash) = opened.catalogue.hash else { panic!("the hash is learned") };
    let blocks = opened.entry_blocks(&hash);
    let ids: Vec<u32> = blocks.iter().flat_map(|block| (0..LANES).map(move |lane| block.id(lane))).collect();
    let stride = entry_stride(hash.axes as usize, hash.code_bits);
    let problems_of = |place: usize, id: u32| {
        let at = (place / LANES + 1) * stride + 4 * (place % LANES) - 4 * LANES;
        verify(&with(&file, SectionKind::EntryBlocks, at, &id.to_le_bytes())).problems
    };
    let of = |at, what| [Problem::Element { kind: SectionKind::EntryBlocks, at, what }];
    let place_of = |id| ids.iter().position(|found| *found == id).expect("a bucket has it");
    let [mut first, mut second] = [place_of(2), place_of(6)];
    if first > second {
        (first, second) = (second, first);
    }
    let met = "is no entry, or one that was met before";
    assert_eq!(problems_of(second, ids[first]), of(second, met));
    assert_eq!(problems_of(second, ENTRIES), of(second, met));
    assert_eq!(problems_of(second, u32::MAX), of(ids[second] as usize, "is in no bucket"));
}
