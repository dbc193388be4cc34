//! What a recognition costs: `cargo bench -p grasp-index`. The data is 6 x 900 views of a hand made
//! of balls.

#[path = "../tests/support/mod.rs"]
mod support;

use criterion::{Criterion, criterion_group, criterion_main};
use grasp_index::{Describer, DescriptorParams, Effort, Index, IndexWriter, SearchOptions, VoteOptions};
use std::hint::black_box;

fn describe(c: &mut Criterion) {
    let hand = support::hand(1, 0.5, &support::view(33.0, 21.0));
    let large = grasp_index::HandImage::from_segmented(640, 640, &upscaled(&hand, 640), 0).expect("a hand");
    for params in [DescriptorParams::paper(), DescriptorParams::default()] {
        let mut describer = Describer::new(&params).expect("the parameters are in range");
        let mut out = vec![0.0; params.dim()];
        let name = params.name();
        c.bench_function(&format!("describe/{name}/{}px", hand.width().max(hand.height())), |b| {
            b.iter(|| describer.describe_into(black_box(&hand), &mut out));
        });
        c.bench_function(&format!("describe/{name}/640px"), |b| {
            b.iter(|| describer.describe_into(black_box(&large), &mut out));
        });
    }
    c.bench_function("rotate/48px", |b| b.iter(|| black_box(&hand).rotated(0.4)));
}

fn upscaled(hand: &grasp_index::HandImage, side: usize) -> Vec<u8> {
    hand.thumbnail(side)
}

fn search(c: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("balls.idx");
    let writer = IndexWriter::create(&path, support::params(6)).expect("the file can be written");
    let summary = support::finish(support::fill(writer, 60, 15)).expect("the index is written");
    println!("{:?} {:?} sigma {:?}", summary.hash, summary.measured, summary.sigma);
    let index = Index::open(&path).expect("the index opens");
    let queries: Vec<_> = (0..60u16)
        .map(|n| {
            let view = support::view(f64::from(n) * 6.2, f64::from(n % 15) * 5.9);
            index.describe(&support::hand(n % 6, 1.0, &view)).expect("pictures are described")
        })
        .collect();
    for (name, effort) in [("search/hashed", Effort::Recall(0.95)), ("search/exact", Effort::Exact)] {
        let options = SearchOptions { effort, ..SearchOptions::default() };
        let mut next = queries.iter().cycle();
        c.bench_function(name, |b| b.iter(|| index.search(next.next().expect("a cycle"), &options)));
    }
    let found = index.search(&queries[0], &SearchOptions::default()).expect("the query fits");
    c.bench_function("vote", |b| {
        b.iter(|| index.vote(black_box(&found.neighbours), &VoteOptions::default()))
    });
    c.bench_function("open", |b| b.iter(|| Index::open(black_box(&path))));
}

criterion_group!(benches, describe, search);
criterion_main!(benches);
