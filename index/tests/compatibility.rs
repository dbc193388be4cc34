//! What becomes of indexes that other versions of this crate have written: those of versions 2 to 7
//! are read, and answer, for ever. (Versions 5 and 6 brought networks: `learned.rs`.)
//!
//! `REGENERATE=1 cargo test -p grasp-index --test compatibility ` writes the fixture of version 7
//! anew. That is right only while no release has written version 7, or for a new version under a
//! new name.

mod support;

use grasp_index::{
    Calibration, DescriptorKind, DescriptorParams, Effort, HashInfo, Index, IndexParams, OpenError,
    SearchOptions, VoteOptions, turned_orientation,
};
use insta::assert_snapshot;
use std::path::PathBuf;
use std::sync::Once;

fn path(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect()
}

/// No release wrote version 1.
#[test]
fn version_1_is_refused() {
    for refused in [Index::open(path("v1.idx")), Index::read(path("v1.idx"))] {
        let refused = refused.expect_err("version 1 is not read");
        assert!(matches!(refused, OpenError::TooOld { wrote: 1, oldest: 2 }));
        insta::allow_duplicates!(
            assert_snapshot!(refused, @"built by an older version of grasp-builder (format 1; this reads 2 and later): build it again")
        );
    }
}

/// One of each hash, of each version that changed them.
fn indexes() -> [Index; 7] {
    static REGENERATED: Once = Once::new();
    REGENERATED.call_once(|| {
        if std::env::var_os("REGENERATE").is_some() {
            // Short descriptors: fixtures stay in the repository for ever.
            let descriptor = DescriptorParams { levels: 3, ..DescriptorParams::upright() };
            let params = IndexParams { descriptor, ..support::small_learned_params() };
            support::write(path("v7-learned.idx"), params).expect("the fixture is written");
        }
    });
    let names = [
        "v2.idx",
        "v2-learned.idx",
        "v3.idx",
        "v3-learned.idx",
        "v4.idx",
        "v4-learned.idx",
        "v7-learned.idx",
    ];
    names.map(|name| Index::open(path(name)).expect("the fixture opens"))
}

#[test]
fn old_and_new_indexes_verify_and_know_what_they_are() {
    let [random_2, learned_2, random_3, learned_3, random, learned, halves] = indexes();
    for index in [&random_2, &random_3, &random] {
        assert!(matches!(index.catalogue().hash, HashInfo::Random(_)));
    }
    for (index, bits) in [(&learned_2, 8), (&learned_3, 8), (&learned, 8), (&halves, 4)] {
        let HashInfo::Learned(hash) = index.catalogue().hash else { panic!("the hash is learned") };
        assert_eq!(hash.code_bits.count(), bits);
    }
    for index in [random_2, learned_2, random_3, learned_3, random, learned, halves] {
        knows_what_it_is(&index);
        // Version 2 has no calibration; these of later ones were made without held-out hands.
        assert_eq!(index.catalogue().calibration, Calibration::default());
    }
}

fn knows_what_it_is(index: &Index) {
    assert_eq!(index.verify().problems, []);
    let catalogue = index.catalogue();
    assert_eq!((index.len(), index.dim()), (36, 84));
    assert_eq!(catalogue.descriptor.kind, DescriptorKind::Default);
    let names: Vec<_> = catalogue.classes.iter().map(|class| (class.name.as_str(), class.cutkosky)).collect();
    assert_eq!(names, [("class-0", 1), ("class-1", 2), ("class-2", 3)]);
    assert_eq!(catalogue.provenance, [("renders".to_owned(), "ball hand".to_owned())]);
    let entry = index.entry(17).expect("there are 36 entries");
    assert_eq!(
        (&*entry.file, entry.stage, &*entry.object),
        ("balls/class-1/az090_el30.png", "grasp", "ball-1")
    );
    let [azimuth, elevation, roll] = entry.view_deg.expect("views are kept");
    assert_eq!((azimuth, elevation), (90.0, 30.0));
    // Version 4 here holds hands that were turned upright.
    let orientation = turned_orientation(f64::from(roll), &entry.orientation.expect("orientations are kept"));
    assert!(orientation.angle_to(&support::view(90.0, 30.0)) < 2e-4);
    assert_eq!(index.thumbnail(17).map(<[u8]>::len), Some(16));
}

#[test]
fn old_and_new_indexes_answer() {
    indexes().iter().for_each(answers);
}

fn answers(index: &Index) {
    // Its own descriptors, so that the answers outlast changes of how pictures are described.
    for id in 0..index.len() as u32 {
        let query = index.descriptor(id).expect("the entry is there").into_owned();
        for effort in [Effort::Recall(0.95), Effort::Exact] {
            let found = index.search(&query, &SearchOptions { k: 3, effort }).expect("the query fits");
            assert_eq!((found.neighbours[0].id, found.neighbours[0].distance), (id, 0.0));
            let vote = index.vote(&found.neighbours[..1], &VoteOptions::default());
            assert_eq!(vote.classes[0].class, (id / 12) as u16);
            assert!((vote.classes[0].probability - 1.0).abs() < 1e-12);
        }
    }
}
