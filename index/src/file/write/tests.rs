//! What another writer might get wrong: every hash is right, and an element makes no sense.

use super::*;
use crate::file::catalogue::ClassInfo;
use crate::file::verify::Problem;
use crate::search::tune::HashParams;
use crate::{EntryError, Index, SearchOptions, VoteOptions};

/// A sound index of 8 entries, ready to be spoilt.
fn writer() -> IndexWriter {
    let class = |name: &str| ClassInfo { name: name.into(), cutkosky: 1 };
    let params = IndexParams {
        classes: vec![class("one"), class("two")],
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        hash: HashParams::Fixed { k: 2, t: 2, buckets: 4 },
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
fn descriptors_in_half_their_size_are_those_rounded_and_make_the_same_hash() {
    let exact = spoilt(|_| ());
    let halved = |originals| {
        let mut writer = writer();
        let mut rows = Sink::memory();
        rows.append(&writer.out.written().expect("it is in memory")).expect("memory");
        writer.params.originals = originals;
        writer.out = Sink::memory();
        writer.out.append(&[0; header::LENGTH]).expect("memory");
        writer.rows = Some(rows);
        writer.finish_bytes().expect("the index is built")
    };
    let length = |bytes: &[u8]| Header::read(bytes).expect("a header").file_length;
    let (halves, none) = (halved(Originals::F16), halved(Originals::None));
    let dim = exact.dim();
    assert_eq!(exact.byte_len() - length(&halves), (2 * 8 * dim) as u64);
    assert_eq!(exact.byte_len() - length(&none), (4 * 8 * dim) as u64);
    // A random hash alone does not do without.
    for bytes in [&halves, &none] {
        let refused = Index::from_bytes(bytes).expect_err("distances cannot be measured");
        assert!(refused.to_string().contains("states a hash that needs the descriptors"), "{refused}");
    }
    let halves: Vec<f16> = halves[header::LENGTH..][..2 * 8 * dim]
        .chunks_exact(2)
        .map(|bytes| f16::from_le_bytes([bytes[0], bytes[1]]))
        .collect();
    for (id, row) in (0..).zip(halves.chunks_exact(dim)) {
        let original = exact.descriptor(id).expect("the entry is there");
        assert!(row.iter().zip(&*original).all(|(half, value)| *half == f16::from_f32(*value)));
    }
}

#[test]
fn text_that_is_none_is_found_and_refused() {
    let index = spoilt(|w| w.columns.files.offsets[4] = 900);
    let problems = index.verify().problems;
    let is_offset =
        |problem: &Problem| matches!(problem, Problem::Element { kind: SectionKind::FileOffsets, at: 5, .. });
    assert!(problems.iter().any(is_offset), "{problems:?}");
    assert_eq!(index.entry(3), Err(EntryError::Corrupt { id: 3, what: "file name" }));
}
