//! Indexes whose columns were spoilt in the writer: every hash is right, and an element makes no
//! sense.

use super::*;
use crate::file::catalogue::ClassInfo;
use crate::file::verify::Problem;
use crate::search::build::{HashParams, RandomParams};
use crate::{Effort, EntryError, Index, Sampling, SearchOptions, VoteOptions};

/// A sound index of 8 entries, ready to be spoilt.
fn writer() -> IndexWriter {
    let class = |name: &str| ClassInfo { name: name.into(), cutkosky: 1 };
    let params = IndexParams {
        classes: vec![class("one"), class("two")],
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        hash: HashParams::Random(RandomParams::Fixed { k: 2, t: 2, buckets: 4 }),
        ..IndexParams::default()
    };
    let dim = params.descriptor.dim();
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..8u16 {
        let descriptor = (0..dim).map(|at| f32::from(n) * 0.1 + (at % 7) as f32).collect();
        let entry = NewEntry { class: n % 2, file: format!("{n}.png"), descriptor, ..NewEntry::default() };
        writer.push(entry).expect("the entry fits");
    }
    writer
}

type Spoil = fn(&mut IndexWriter);

fn spoilt(spoil: impl FnOnce(&mut IndexWriter)) -> Index {
    let mut writer = writer();
    spoil(&mut writer);
    Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("opening reads no section")
}

fn problem(index: &Index) -> (SectionKind, usize) {
    match index.verify().problems.as_slice() {
        [Problem::Element { kind, at, .. }] => (*kind, *at),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_index_is_sound_before_it_is_spoilt() {
    assert!(spoilt(|_| ()).verify().is_sound());
}

#[test]
fn numbers_of_nothing_are_found_and_refused() {
    let cases: [(&str, SectionKind, Spoil); 5] = [
        ("class", SectionKind::Labels, |w| w.columns.labels[3] = 2),
        ("stage", SectionKind::Stages, |w| w.columns.stages[3] = 1),
        ("hand shape", SectionKind::HandShapes, |w| w.columns.hand_shapes[3] = 1),
        ("object", SectionKind::Objects, |w| w.columns.object_of[3] = 1),
        ("orientation", SectionKind::Orientations, |w| w.columns.orientations[3] = [0; 4]),
    ];
    for (what, kind, spoil) in cases {
        let index = spoilt(spoil);
        assert_eq!(problem(&index), (kind, 3));
        assert_eq!(index.entry(3), Err(EntryError::Corrupt { id: 3, what }));
        assert!(index.entry(2).is_ok());
        // It is still found, and where it has no class or orientation it has no vote.
        let query = index.descriptor(3).expect("the entry is there").to_vec();
        let found = index.search(&query, &SearchOptions::default()).expect("the query fits");
        let vote = index.vote(&found.neighbours, &VoteOptions::default());
        assert!(vote.orientation.spread_deg.is_finite());
    }
}

#[test]
fn angles_beyond_a_turn_are_found() {
    let index = spoilt(|w| w.columns.views[3] = [0, 36_000, 0]);
    assert_eq!(problem(&index), (SectionKind::Views, 3 * 3 + 1));
}

#[test]
fn descriptors_are_kept_as_they_are_or_in_half_their_size_or_not_at_all() {
    let built = |originals| {
        let mut writer = writer();
        let mut rows = Sink::memory();
        rows.append(&writer.out.written().expect("it is in memory")).expect("memory");
        writer.params.originals = originals;
        writer.params.hash = HashParams::Learned;
        if originals != Originals::F32 {
            writer.out = Sink::memory();
            writer.out.append(&[0; header::LENGTH]).expect("memory");
            writer.rows = Some(rows);
        }
        Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("it opens")
    };
    let exact = built(Originals::F32);
    for (originals, bytes) in [(Originals::F32, 4), (Originals::F16, 2), (Originals::None, 0)] {
        let index = built(originals);
        let section = index.catalogue().sections[0];
        assert_eq!(section.length, (bytes * 8 * index.dim()) as u64, "{originals:?}");
        assert!(index.verify().is_sound(), "{originals:?}");
        for id in 0..8 {
            let original = exact.descriptor(id).expect("the entry is there");
            let kept = index.descriptor(id);
            assert_eq!(kept.is_some(), bytes > 0);
            let rounded = |value: f32| if bytes == 2 { f16::from_f32(value).to_f32() } else { value };
            if let Some(kept) = kept {
                assert!(kept.iter().zip(&*original).all(|(&kept, &value)| kept == rounded(value)));
            }
            let found = index.search(&original, &SearchOptions::default()).expect("the query fits");
            let nearest = found.neighbours.first().expect("there are eight");
            assert_eq!(nearest.id, id, "{originals:?}");
            assert!(nearest.distance < 0.05, "{originals:?}: {}", nearest.distance);
        }
        let all = SearchOptions { effort: Effort::Exact, ..SearchOptions::default() };
        assert_eq!(index.search(&vec![0.0; index.dim()], &all).is_ok(), bytes > 0);
    }
}

#[test]
fn a_random_hash_does_not_do_without_descriptors() {
    for originals in [Originals::F16, Originals::None] {
        let params = IndexParams { originals, ..writer().params };
        assert!(matches!(IndexWriter::new(params), Err(BuildError::Params(_))));
    }
}

#[test]
fn text_that_is_none_is_found_and_refused() {
    let index = spoilt(|w| w.columns.files.offsets[4] = 900);
    assert_eq!(problem(&index), (SectionKind::FileOffsets, 5));
    assert_eq!(index.entry(3), Err(EntryError::Corrupt { id: 3, what: "file name" }));
}

#[test]
fn an_index_needs_no_newer_reader_than_its_content_does() {
    let least_reader = |sampling, hash| {
        let mut writer = writer();
        writer.params.hash = hash;
        writer.params.descriptor.sampling = sampling;
        let bytes = writer.finish_bytes().expect("the index is built");
        Header::read(&bytes).map(|header| (header.least_reader, header.version)).expect("the header is sound")
    };
    let random = writer().params.hash;
    assert_eq!(least_reader(Sampling::KeepAspect { side: 48 }, random), (3, 7));
    assert_eq!(least_reader(Sampling::Upright { side: 48 }, random), (4, 7));
    assert_eq!(least_reader(Sampling::Upright { side: 48 }, HashParams::Learned), (7, 7));
}
