//! An index written by version 1 of the format is read, and answers, for ever.
//!
//! `REGENERATE=1 cargo test -p grasp-index --test compatibility` writes the fixture anew. That is right only while no
//! release has written version 1, or for a new version under a new name.

mod support;

use grasp_index::{DescriptorKind, HashInfo, Index, RandomHash, SearchOptions, VoteOptions};
use std::path::PathBuf;
use std::sync::Once;

fn fixture() -> Index {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", "v1.idx"].iter().collect();
    static REGENERATED: Once = Once::new();
    REGENERATED.call_once(|| {
        if std::env::var_os("REGENERATE").is_some() {
            let go_on = |_, _| std::ops::ControlFlow::Continue(());
            support::small().finish(&path, &go_on).expect("the fixture is written");
        }
    });
    Index::open(path).expect("the fixture opens")
}

#[test]
fn version_1_verifies() {
    assert_eq!(fixture().verify().problems, []);
}

#[test]
fn version_1_knows_what_it_is() {
    let index = fixture();
    let catalogue = index.catalogue();
    assert_eq!((index.len(), index.dim()), (36, 84));
    assert_eq!(catalogue.descriptor.kind, DescriptorKind::Default);
    assert_eq!(catalogue.hash, HashInfo::Random(RandomHash { planes: 3, tables: 3, buckets: 4, probes: 1 }));
    let names: Vec<_> = catalogue.classes.iter().map(|class| (class.name.as_str(), class.cutkosky)).collect();
    assert_eq!(names, [("class-0", 1), ("class-1", 2), ("class-2", 3)]);
    assert_eq!(catalogue.provenance, [("renders".to_owned(), "ball hand".to_owned())]);
    let entry = index.entry(17).expect("there are 36 entries");
    assert_eq!((entry.file, entry.stage, entry.object), ("balls/class-1/az090_el30.png", "grasp", "ball-1"));
    assert!(entry.orientation.angle_to(&support::view(90.0, 30.0)) < 1e-6);
    assert_eq!(index.thumbnail(17).map(<[u8]>::len), Some(16));
}

#[test]
fn version_1_answers() {
    let index = fixture();
    // Its own descriptors, so that the answers outlast changes of how pictures are described.
    for id in 0..index.len() as u32 {
        let query = index.descriptor(id).expect("the entry is there").to_vec();
        let found = index
            .search(&query, &SearchOptions { k: 3, ..SearchOptions::default() })
            .expect("the query fits");
        assert_eq!((found.neighbours[0].id, found.neighbours[0].distance), (id, 0.0));
        let vote = index.vote(&found.neighbours[..1], &VoteOptions::default());
        assert_eq!(vote.classes[0].class, (id / 12) as u16);
        assert!((vote.classes[0].probability - 1.0).abs() < 1e-12);
    }
}
