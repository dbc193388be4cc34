//! Indexes of vectors that came from elsewhere, with all that is known of them, or some of it, or
//! nothing.

mod support;

use grasp_index::{
    CannotRecognise, ClassInfo, DescriptorParams, Effort, Index, IndexParams, IndexWriter, KeptFields,
    NewEntry, SearchError, SearchOptions, SectionKind, VoteOptions,
};
use std::ops::ControlFlow;

const DIM: usize = 5;

fn vector(n: usize) -> Vec<f32> {
    (0..DIM).map(|at| ((n * 31 + at * 17) % 101) as f32 / 10.0).collect()
}

fn built(kept: KeptFields) -> Index {
    let mut params =
        IndexParams { descriptor: DescriptorParams::raw(DIM as u32), kept, ..IndexParams::default() };
    if kept.labels {
        params.classes = ["one", "two"].map(|name| ClassInfo { name: name.into(), cutkosky: 0 }).to_vec();
        params.hand_shapes = vec!["somebody's".into()];
        params.stages = vec!["grasp".into()];
    }
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..60 {
        let entry = NewEntry {
            class: n as u16 % 2,
            file: format!("{n}.png"),
            object: format!("object {}", n % 3),
            azimuth_deg: 355.25,
            elevation_deg: -12.5,
            descriptor: vector(n),
            ..NewEntry::default()
        };
        writer.push(entry).expect("the entry fits");
    }
    Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("the index opens")
}

fn exact() -> SearchOptions {
    SearchOptions { k: 3, effort: Effort::Exact }
}

#[test]
fn vectors_alone_can_be_searched_and_tell_nothing_else() {
    let index = built(KeptFields::nothing());
    assert!(index.verify().is_sound());
    assert_eq!((index.len(), index.dim()), (60, DIM));
    let found = index.search(&vector(17), &exact()).expect("the query fits");
    assert_eq!((found.neighbours[0].id, found.neighbours[0].distance), (17, 0.0));
    let entry = index.entry(17).expect("the entry is there");
    assert_eq!((entry.class, &*entry.file, &*entry.object, entry.view_deg), (None, "", "", None));
    assert_eq!(entry.orientation, None);
    assert!(index.entry(60).is_err());
    assert!(index.labels().is_empty() && index.source_hashes().is_empty());
    let vote = index.vote(&found.neighbours, &VoteOptions::default());
    assert!(vote.classes.is_empty());
    assert_eq!(vote.orientation.spread_deg, 180.0);
    assert_eq!(index.check_recognises(), Err(CannotRecognise::RawDescriptors));
    use SectionKind::*;
    let empty = [Labels, Stages, HandShapes, Orientations, Views, SourceHashes];
    let texts = [FileOffsets, FileText, Objects, ObjectOffsets, ObjectText, Thumbnails];
    for section in &index.catalogue().sections {
        let is_empty = empty.iter().chain(&texts).any(|&kind| kind == section.kind);
        assert!(!is_empty || section.length == 0, "{:?}", section.kind);
    }
}

#[test]
fn true_neighbours_of_many_are_those_of_each_and_can_be_stopped() {
    let index = built(KeptFields::nothing());
    let queries: Vec<f32> = (0..40).flat_map(|n| vector(n * 3 + 1)).collect();
    let mut one_by_one = Vec::new();
    for query in queries.chunks(DIM) {
        one_by_one.extend(index.search(query, &exact()).expect("the query fits").neighbours);
    }
    let mut searcher = index.searcher();
    let on_all_threads = searcher.exact(&queries, 3, &|_| ControlFlow::Continue(()));
    assert_eq!(on_all_threads, Ok(Some(one_by_one.clone())));
    let mut in_a_batch = Vec::new();
    searcher.batch(&queries, &exact(), &mut in_a_batch).expect("the queries fit");
    assert_eq!(in_a_batch, one_by_one);
    assert_eq!(searcher.exact(&queries, 3, &|_| ControlFlow::Break(())), Ok(None));
    let too_short = searcher.exact(&queries[1..], 3, &|_| ControlFlow::Continue(()));
    assert_eq!(too_short, Err(SearchError::WrongLength { expected: DIM, found: DIM - 1 }));
    let none = searcher.exact(&queries, 0, &|_| ControlFlow::Continue(()));
    assert_eq!(none, Err(SearchError::NoNeighbours));
}

#[test]
fn labels_without_orientations_vote_on_the_class_alone() {
    let index = built(KeptFields { labels: true, views: true, ..KeptFields::nothing() });
    assert!(index.verify().is_sound());
    let found = index.search(&vector(17), &exact()).expect("the query fits");
    let vote = index.vote(&found.neighbours[..1], &VoteOptions::default());
    assert_eq!((vote.classes[0].name.as_str(), vote.classes[0].probability), ("two", 1.0));
    assert_eq!(vote.orientation.spread_deg, 180.0);
    let entry = index.entry(17).expect("the entry is there");
    assert_eq!((entry.class, &*entry.object, &*entry.file), (Some(1), "object 2", ""));
    assert_eq!(entry.view_deg, Some([355.25, -12.5, 0.0]));
}

#[test]
fn everything_but_the_vectors_takes_21_bytes_an_entry() {
    let index = built(KeptFields { files: false, sources: false, ..KeptFields::default() });
    let of_entries = ["Labels", "Stages", "HandShapes", "Orientations", "Views", "Objects"];
    let sections = index.catalogue().sections.iter();
    let bytes: u64 =
        sections.filter(|s| of_entries.contains(&format!("{:?}", s.kind).as_str())).map(|s| s.length).sum();
    assert_eq!(bytes, 60 * 21);
}

#[test]
fn pictures_are_described_by_no_raw_vectors() {
    let hand = support::hand(0, 0.0, &support::view(0.0, 45.0));
    assert_eq!(built(KeptFields::default()).describe(&hand), Err(CannotRecognise::RawDescriptors));
    let params = IndexParams { kept: KeptFields::nothing(), ..IndexParams::default() };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    let descriptor = DescriptorParams::default().describe(&hand).unwrap();
    writer.push(NewEntry { descriptor, ..NewEntry::default() }).expect("the entry fits");
    let index = Index::from_bytes(&writer.finish_bytes().expect("built")).expect("the index opens");
    assert!(index.describe(&hand).is_ok());
    assert_eq!(index.check_recognises(), Err(CannotRecognise::NoLabels));
}
