//! What a search was measured to find is what it finds, of queries like those that were held out.

use grasp_index::{
    DescriptorParams, Effort, HashInfo, HashParams, Index, IndexParams, IndexWriter, KeptFields, NewEntry,
    Originals, RandomParams, SearchError, SearchOptions,
};
use insta::assert_snapshot;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const DIM: usize = 24;
const ROWS: usize = 3000;
const CLUSTERS: u64 = 100;

/// Numbers from -1 to 1.
fn drawn(seed: u64) -> impl Iterator<Item = f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || rng.random_range(-1.0..1.0))
}

/// A row near the middle of a cluster, `spread` times as far from it as clusters are apart.
fn row(seed: u64, spread: f32) -> Vec<f32> {
    let middle = drawn(ChaCha8Rng::seed_from_u64(seed).random_range(0..CLUSTERS));
    middle.zip(drawn(1_000 + seed)).map(|(middle, away)| middle + spread * away).take(DIM).collect()
}

fn rows(from: u64, count: usize, spread: f32) -> Vec<Vec<f32>> {
    (from..).map(|seed| row(seed, spread)).take(count).collect()
}

fn built(rows: &[Vec<f32>], held_out: &[Vec<f32>], originals: Originals) -> Index {
    let params = IndexParams {
        descriptor: DescriptorParams::raw(DIM as u32),
        kept: KeptFields::nothing(),
        originals,
        held_out: held_out.concat(),
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for row in rows {
        writer.push(NewEntry { descriptor: row.clone(), ..NewEntry::default() }).expect("the entry fits");
    }
    Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("the index opens")
}

/// The share of queries whose first of `k` neighbours is the nearest of `rows`.
fn successes(index: &Index, rows: &[Vec<f32>], queries: &[Vec<f32>], k: usize, effort: Effort) -> f64 {
    let squared =
        |one: &[f32], other: &[f32]| one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
    let is_right = |query: &&Vec<f32>| {
        let nearest = rows.iter().map(|row| squared(row, query)).fold(f32::INFINITY, f32::min);
        let found = index.search(query, &SearchOptions { k, effort }).expect("the query fits");
        found
            .neighbours
            .first()
            .is_some_and(|first| squared(&rows[first.id as usize], query) <= nearest * 1.0001)
    };
    queries.iter().filter(is_right).count() as f64 / queries.len() as f64
}

#[test]
fn few_neighbours_are_found_as_surely_as_many() {
    let (all, held_out) = (rows(0, ROWS, 0.1), rows(50_000, 500, 0.1));
    let index = built(&all, &held_out, Originals::F32);
    let effort = Effort::Success { eps: 0.0, success: 0.95 };
    let queries = rows(90_000, 400, 0.1);
    for k in [1, 2, 10] {
        let found = successes(&index, &all, &queries, k, effort);
        assert!(found > 0.93, "{found} of the queries find their nearest, {k} asked for");
    }
}

#[test]
fn rows_that_are_held_out_are_measured_as_they_are() {
    let (all, held_out) = (rows(0, ROWS, 0.01), rows(50_000, 500, 0.01));
    let index = built(&all, &held_out, Originals::F32);
    let measured = &index.catalogue().measured;
    assert_eq!((measured.held_out, measured.noise), (true, [0.0; 2]));
    let queries = rows(90_000, 400, 0.01);
    for wanted in [0.9, 0.99] {
        let found = successes(&index, &all, &queries, 10, Effort::Success { eps: 0.0, success: wanted });
        assert!(found > wanted - 0.02, "{found} of the queries find their nearest, {wanted} wanted");
    }
}

/// K and T are chosen so that 0.95 of the queries find a neighbour within 1.05 of the nearest, by
/// as little work as does that.
#[test]
fn the_papers_hash_is_tuned_to_what_it_shall_find_at_little_cost() {
    let (all, queries) = (rows(0, 1000, 0.1), rows(90_000, 300, 0.1));
    let params = IndexParams {
        descriptor: DescriptorParams::raw(DIM as u32),
        kept: KeptFields::nothing(),
        hash: HashParams::Random(RandomParams::Auto),
        held_out: rows(50_000, 300, 0.1).concat(),
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for row in &all {
        writer.push(NewEntry { descriptor: row.clone(), ..NewEntry::default() }).expect("the entry fits");
    }
    let index = Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("it opens");
    let HashInfo::Random(hash) = index.catalogue().hash else { panic!("the hash is random") };
    assert_eq!(hash.buckets, 1024, "about as many as rows: {hash:?}");
    // The first that are measured: one bucket a table.
    let measured = index.catalogue().measured.curve[0];
    assert_eq!(measured.probes, 1);
    assert!(measured.success() >= 0.95 && measured.share_of_database < 0.25, "{hash:?}: {measured:?}");
    let found = successes(&index, &all, &queries, 1, Effort::Probes(1));
    assert!(found >= 0.92, "{found} of the queries find their nearest by {hash:?}");
}

#[test]
fn what_is_kept_in_half_the_bits_is_measured_so() {
    // So far from 0, half the bits leave two decimals less than the rows differ by.
    let far = |rows: Vec<Vec<f32>>| -> Vec<Vec<f32>> {
        rows.into_iter().map(|row| row.into_iter().map(|value| value + 1_000.0).collect()).collect()
    };
    let (all, held_out) = (far(rows(0, ROWS, 0.5)), far(rows(50_000, 500, 0.5)));
    let [whole, halved] = [Originals::F32, Originals::F16].map(|originals| built(&all, &held_out, originals));
    let best = |index: &Index| index.catalogue().measured.best_recall();
    assert!(best(&whole) > 0.95 && best(&halved) < 0.8, "{} and {}", best(&whole), best(&halved));
}

#[test]
fn what_cannot_be_found_is_said() {
    let all = rows(0, ROWS, 0.1);
    let index = built(&all, &[], Originals::None);
    let search = |effort| index.search(&all[3], &SearchOptions { k: 1, effort });
    assert_eq!(search(Effort::Exact), Err(SearchError::NoOriginals));
    assert!(matches!(search(Effort::Recall(1.0)), Err(SearchError::NotReached { .. })));
    let huge = vec![2e15; DIM];
    assert_eq!(index.search(&huge, &SearchOptions::default()), Err(SearchError::Huge { at: 0 }));
}

#[test]
fn differences_too_small_for_distances_are_refused_and_equal_rows_are_not() {
    let finished = |scale: f32, originals| {
        let params = IndexParams {
            descriptor: DescriptorParams::raw(DIM as u32),
            kept: KeptFields::nothing(),
            originals,
            ..IndexParams::default()
        };
        let mut writer = IndexWriter::new(params).expect("the parameters are sound");
        for seed in 0..50 {
            let descriptor = row(seed, 0.1).iter().map(|value| scale * value).collect();
            writer.push(NewEntry { descriptor, ..NewEntry::default() }).expect("the entry fits");
        }
        writer.finish_bytes().map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(finished(0.0, Originals::F32), Ok(()));
    assert_eq!(finished(1e-11, Originals::F32), Ok(()));
    assert_snapshot!(finished(1e-22, Originals::F32).unwrap_err(), @"the descriptors differ by less than 1e-12, too little to measure distances by: multiply all descriptors by the same number");
    assert_snapshot!(finished(1e-22, Originals::None).unwrap_err(), @"the descriptors differ by less than 1e-12, too little to measure distances by: multiply all descriptors by the same number");
    assert_eq!(finished(1e-3, Originals::F16), Ok(()));
    assert_snapshot!(finished(1e-8, Originals::F16).unwrap_err(), @"the descriptors differ by less than 6e-5, too little for 16 bits: keep the originals as f32, or multiply all descriptors by the same number");
}
