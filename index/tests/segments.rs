//! Segments of one index answer as it does: to the last bit, at any effort.

use std::ops::ControlFlow;
use std::sync::LazyLock;

use grasp_index::{
    AtomicFile, BuildError, ClassInfo, DescriptorParams, Effort, HashParams, Index, IndexParams, IndexWriter,
    Neighbour, NewEntry, Originals, RandomParams, SearchError, SearchOptions, Segments, Shortlist,
};
use proptest::prelude::*;

const DIM: usize = 6;

/// Some thousand rows in clumps, on a grid, so that equal distances are frequent.
fn row(n: usize) -> Vec<f32> {
    let clump = n * 7919 % 61;
    let value = |at: usize| ((clump * (at + 3) * 37) % 64 + (n * (2 * at + 1) * 613) % 9) as f32 / 8.0;
    (0..DIM).map(value).collect()
}

/// What one who has only the shortlists of all segments makes of them, each asked by itself.
fn by_shortlists(segments: &Segments, query: &[f32], options: &SearchOptions) -> Vec<Neighbour> {
    let mut effort = options.effort;
    loop {
        let options = SearchOptions { effort, ..*options };
        let mut candidates: Vec<(u32, Neighbour)> = Vec::new();
        let mut first: Option<Shortlist> = None;
        let mut start = 0;
        for index in segments.indexes() {
            let numbered = |near: Neighbour| Neighbour { id: near.id + start, ..near };
            match index.searcher().shortlist(query, &options).unwrap() {
                Some(shortlist) => {
                    candidates.extend(shortlist.candidates.iter().map(|&(key, near)| (key, numbered(near))));
                    first.get_or_insert(shortlist);
                }
                None => {
                    let found = index.search(query, &options).unwrap().neighbours;
                    candidates.extend(found.into_iter().map(|near| (0, numbered(near))));
                }
            }
            start += index.len() as u32;
        }
        if let Some(Shortlist { probes, most_probes, keep, .. }) = first {
            if candidates.len() < options.k.min(segments.len()) {
                effort = if probes < most_probes { Effort::Probes(2 * probes) } else { Effort::Exact };
                continue;
            }
            candidates.sort_by_key(|(key, near)| (*key, near.id));
            candidates.truncate(keep.unwrap_or(usize::MAX));
        }
        let mut found: Vec<Neighbour> = candidates.into_iter().map(|(_, near)| near).collect();
        found.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.id.cmp(&b.id)));
        found.truncate(options.k);
        return found;
    }
}

/// An index, and its segments: in one, two, three and four.
struct Family {
    single: Index,
    segments: Vec<Segments>,
}

fn cuts(entries: usize) -> Vec<Vec<usize>> {
    let n = entries;
    vec![vec![0, n], vec![0, n / 3, n], vec![0, 1, n / 2, n], vec![0, n / 4, n / 2, n - 17, n]]
}

fn segment(index: &Index, from: usize, to: usize) -> Result<Index, BuildError> {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let path = folder.path().join("segment.idx");
    let file = AtomicFile::create(&path)?;
    let note = vec![("segment".to_owned(), format!("{from} to {to}"))];
    index.write_segment(from as u32..to as u32, note, file, &|| ControlFlow::Continue(()))?;
    Ok(Index::read(&path).expect("the segment opens"))
}

fn single(entries: usize, hash: HashParams, originals: Originals) -> Index {
    let params = IndexParams {
        descriptor: DescriptorParams::raw(DIM as u32),
        hash,
        originals,
        classes: ["one", "two"].map(|name| ClassInfo { name: name.into(), cutkosky: 0 }).to_vec(),
        hand_shapes: vec!["slim".into(), "broad".into()],
        stages: vec!["grasp".into()],
        thumbnail_side: 1,
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..entries {
        let entry = NewEntry {
            class: n as u16 % 2,
            hand_shape: n as u16 / 5 % 2,
            file: format!("{n}.png"),
            object: format!("object {}", n % 3),
            azimuth_deg: (n % 360) as f32,
            source_hash: n as u64,
            descriptor: row(n),
            thumbnail: Some(vec![n as u8]),
            ..NewEntry::default()
        };
        writer.push(entry).expect("the entry fits");
    }
    let bytes = writer.finish_bytes().expect("the index is built");
    Index::from_bytes(&bytes).expect("the index opens")
}

fn family(entries: usize, hash: HashParams, originals: Originals) -> Family {
    let single = single(entries, hash, originals);
    let segments = cuts(entries).into_iter().map(|cuts| {
        let each = cuts.windows(2).map(|pair| segment(&single, pair[0], pair[1]).expect("it is written"));
        Segments::new(each.collect()).expect("they go together")
    });
    Family { segments: segments.collect(), single }
}

static FAMILIES: LazyLock<Vec<Family>> = LazyLock::new(|| {
    let random = HashParams::Random(RandomParams::Fixed { k: 7, t: 3, buckets: 50 });
    vec![
        // So many that centres come in groups.
        family(24_000, HashParams::Learned, Originals::F32),
        family(3_000, HashParams::Learned, Originals::F16),
        family(3_000, HashParams::Learned, Originals::None),
        family(3_000, random, Originals::F32),
    ]
});

fn effort() -> impl Strategy<Value = Effort> {
    prop_oneof![
        prop_oneof![Just(0.5), Just(0.9), Just(0.95), Just(0.99), Just(1.0)].prop_map(Effort::Recall),
        (prop_oneof![Just(0.0), Just(0.05)], 0.5..1.0)
            .prop_map(|(eps, success)| Effort::Success { eps, success }),
        (1..40u32).prop_map(Effort::Probes),
        Just(Effort::Probes(u32::MAX)),
        Just(Effort::Exact),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]
    #[test]
    fn segments_answer_as_their_index(
        family in 0..4usize, of in 0..4usize, k in prop_oneof![1..51usize, Just(700), Just(5_000)], effort in effort(),
        n in 0..30_000usize, moved in prop_oneof![Just([0.0; DIM]), prop::array::uniform6(-0.5..0.5f32)]
    ) {
        let Family { single, segments } = &FAMILIES[family];
        let segments = &segments[of];
        prop_assert!(segments.are_of_one_index());
        let query: Vec<f32> = row(n).iter().zip(moved).map(|(value, moved)| value + moved).collect();
        let options = SearchOptions { k, effort };
        let expected = single.search(&query, &options);
        let found = segments.search(&query, &options);
        prop_assert_eq!(&found, &expected);

        let queries = [&query[..], &row(n + 1), &row(n / 2)].concat();
        let (mut together, mut apart) = (Vec::new(), Vec::new());
        let batched = single.searcher().batch(&queries, &options, &mut apart);
        prop_assert_eq!(segments.searcher().batch(&queries, &options, &mut together), batched);
        prop_assert_eq!(&together, &apart);
        if let Ok(expected) = expected {
            let bits = |search: &grasp_index::Search| -> Vec<(u32, u32)> {
                search.neighbours.iter().map(|near| (near.id, near.distance.to_bits())).collect()
            };
            prop_assert_eq!(bits(&found.unwrap()), bits(&expected));
            prop_assert_eq!(&apart[..expected.neighbours.len()], &expected.neighbours[..]);
            prop_assert_eq!(by_shortlists(segments, &query, &options), expected.neighbours);
        } else {
            let are_missing =
                matches!(found, Err(SearchError::NoOriginals | SearchError::NotReached { .. }));
            prop_assert!(are_missing, "{found:?}");
        }
    }
}

#[test]
fn segments_hold_the_entries_of_their_index() {
    for Family { single, segments } in &*FAMILIES {
        for segments in segments {
            assert_eq!(segments.len(), single.len());
            for index in segments.indexes() {
                let problems = index.verify().problems;
                assert!(problems.is_empty(), "{problems:?}");
                assert_eq!(index.catalogue().calibration, single.catalogue().calibration);
                assert_eq!(index.catalogue().provenance.last().unwrap().0, "segment");
            }
            for id in (0..single.len() as u32).step_by(7) {
                let (index, own) = segments.locate(id).expect("it is in one of them");
                assert_eq!(index.entry(own), single.entry(id));
                assert_eq!(index.descriptor(own), single.descriptor(id));
                assert_eq!(index.thumbnail(own), single.thumbnail(id));
                assert_eq!(index.source_hashes()[own as usize], single.source_hashes()[id as usize]);
            }
        }
    }
}

#[test]
fn others_are_searched_each_by_itself() {
    let halves = |entries, hash| {
        let Family { single, .. } = family(entries, hash, Originals::F32);
        single
    };
    let alike = vec![halves(300, HashParams::Learned), halves(301, HashParams::Learned)];
    let segments = Segments::new(alike).unwrap();
    assert!(!segments.are_of_one_index());
    let found = segments.search(&row(5), &SearchOptions { k: 2, effort: Effort::Exact }).unwrap();
    assert_eq!(found.neighbours.iter().map(|near| near.id).collect::<Vec<_>>(), [5, 305]);
}

#[test]
fn what_makes_no_segment_is_refused() {
    let single = &FAMILIES[1].single;
    assert!(matches!(segment(single, 5, 5), Err(BuildError::Empty)));
    assert!(matches!(segment(single, 5, 3_001), Err(BuildError::Params(_))));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segment.idx");
    let stopped = single
        .write_segment(0..9, Vec::new(), AtomicFile::create(&path).unwrap(), &|| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(BuildError::Stopped)));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn an_entry_that_is_alone_is_found() {
    let random = HashParams::Random(RandomParams::Fixed { k: 2, t: 1, buckets: 4 });
    let learned = HashParams::Learned;
    for (hash, originals) in [(learned, Originals::F32), (learned, Originals::None), (random, Originals::F32)]
    {
        let single = single(1, hash, originals);
        let options = SearchOptions { k: 10, effort: Effort::Recall(0.99) };
        let found = single.search(&row(0), &options).expect("its search was measured to find all");
        assert_eq!(found.neighbours.iter().map(|near| near.id).collect::<Vec<_>>(), [0]);
    }
}
