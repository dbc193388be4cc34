//! What a search costs, step by step and as a whole: `cargo bench -p grasp-index --features parts
//! --bench search`.
//!
//! The data is 5,400 vectors around a few hundred centres in a space that is flat in most
//! directions, as descriptors are. Each step works on the same few queries over and over, in a warm
//! cache; only `search/` goes from query to query as programs do.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use grasp_index::{
    DescriptorParams, Effort, HashParams, Index, IndexParams, IndexWriter, KeptFields, NewEntry,
    RandomParams, SearchOptions,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::hint::black_box;

const DIM: usize = 84;
const ENTRIES: usize = 5_400;
const QUERIES: usize = 500;
/// Directions in which the vectors vary.
const FLAT: usize = 24;
const CENTRES: usize = 300;
const PROBES: u32 = 8;
const K: usize = 10;

/// Rows of the dimension of a descriptor, from the same centres for each seed.
fn rows(count: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let draw = |rng: &mut ChaCha8Rng, length: usize, scale: f32| -> Vec<f32> {
        (0..length)
            .map(|_| scale * (rng.random_range(-1.0..1.0f32) + rng.random_range(-1.0..1.0f32)))
            .collect()
    };
    let axes: Vec<Vec<f32>> = (0..FLAT).map(|axis| draw(&mut rng, DIM, 0.3 / (1.0 + axis as f32))).collect();
    let centres: Vec<Vec<f32>> = (0..CENTRES).map(|_| draw(&mut rng, FLAT, 1.0)).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut rows = Vec::with_capacity(count * DIM);
    for _ in 0..count {
        let place = draw(&mut rng, FLAT, 0.25);
        let centre = &centres[rng.random_range(0..CENTRES as u64) as usize];
        let mut row = draw(&mut rng, DIM, 0.01);
        for ((axis, place), centre) in axes.iter().zip(&place).zip(centre) {
            row.iter_mut().zip(axis).for_each(|(value, axis)| *value += axis * (place + centre));
        }
        rows.extend(row);
    }
    rows
}

fn index(hash: HashParams) -> (Index, Vec<f32>) {
    let params = IndexParams {
        descriptor: DescriptorParams::raw(DIM as u32),
        kept: KeptFields::nothing(),
        hash,
        held_out: rows(QUERIES, 4),
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are right");
    for row in rows(ENTRIES, 2).chunks(DIM) {
        writer.push(NewEntry { descriptor: row.to_vec(), ..NewEntry::default() }).expect("the entry fits");
    }
    let bytes = writer.finish_bytes().expect("the index is built");
    (Index::from_bytes(&bytes).expect("the index opens"), rows(QUERIES, 3))
}

fn steps(c: &mut Criterion) {
    let (index, queries) = index(HashParams::Learned);
    let query = &queries[..DIM];
    for mut parts in index.parts() {
        let path = parts.path();
        c.bench_function(&format!("rotate/{path}"), |b| b.iter(|| parts.rotate(black_box(query))));
        c.bench_function(&format!("rank/{path}/{PROBES} buckets"), |b| {
            b.iter(|| parts.rank(black_box(PROBES)))
        });
        let scanned = parts.held();
        let mut group = c.benchmark_group("scan");
        group.throughput(Throughput::Elements(u64::from(scanned)));
        group.bench_function(BenchmarkId::new(path, scanned), |b| b.iter(|| parts.scan(black_box(K))));
        group.finish();
        let measured = parts.rerank(query, K);
        let mut group = c.benchmark_group("rerank");
        group.throughput(Throughput::Elements(measured as u64));
        group.bench_function(BenchmarkId::new(path, measured), |b| {
            b.iter(|| parts.rerank(black_box(query), K))
        });
        group.finish();
    }
}

fn searches(c: &mut Criterion) {
    let (learned, queries) = index(HashParams::Learned);
    let (random, _) = index(HashParams::Random(RandomParams::Auto));
    let mut group = c.benchmark_group("search");
    group.throughput(Throughput::Elements(QUERIES as u64));
    for (name, index, effort) in [
        ("recall 0.95", &learned, Effort::Recall(0.95)),
        ("recall 0.99", &learned, Effort::Recall(0.99)),
        ("eps-success 0.99", &learned, Effort::Success { eps: 0.05, success: 0.99 }),
        ("random hash", &random, Effort::Success { eps: 0.05, success: 0.95 }),
        ("exact", &learned, Effort::Exact),
    ] {
        let options = SearchOptions { k: K, effort };
        let (mut searcher, mut found) = (index.searcher(), Vec::new());
        group.bench_function(name, |b| {
            b.iter(|| {
                found.clear();
                searcher.batch(black_box(&queries), &options, &mut found)
            });
        });
    }
    group.finish();
    let (mut searcher, mut next) = (learned.searcher(), queries.chunks(DIM).cycle());
    let options = SearchOptions::default();
    c.bench_function("search/one by one", |b| {
        b.iter(|| searcher.search(next.next().expect("a cycle"), &options))
    });
}

criterion_group!(benches, steps, searches);
criterion_main!(benches);
