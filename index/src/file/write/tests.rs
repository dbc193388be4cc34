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
        ("orientation", SectionKind::Orientations, |w| w.columns.orientations[3] = [0.0; 4]),
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
fn text_that_is_none_is_found_and_refused() {
    let index = spoilt(|w| w.columns.files.offsets[4] = 900);
    let problems = index.verify().problems;
    let is_offset =
        |problem: &Problem| matches!(problem, Problem::Element { kind: SectionKind::FileOffsets, at: 5, .. });
    assert!(problems.iter().any(is_offset), "{problems:?}");
    assert_eq!(index.entry(3), Err(EntryError::Corrupt { id: 3, what: "file name" }));
}
