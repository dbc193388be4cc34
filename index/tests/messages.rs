//! What a user reads when something is wrong.

mod support;

use grasp_index::{
    BuildError, Calibration, DescriptorParams, HandImage, HashParams, Index, IndexParams, IndexWriter,
    KeptFields, NewEntry, Originals, RandomParams, SearchOptions,
};
use insta::{allow_duplicates, assert_snapshot};
use nalgebra::UnitQuaternion;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

fn small() -> Vec<u8> {
    support::small().finish_bytes().expect("the index is built")
}

fn opening(bytes: &[u8]) -> String {
    Index::from_bytes(bytes).expect_err("the bytes are broken").to_string()
}

#[test]
fn of_files_that_are_no_index() {
    assert_snapshot!(opening(b""), @"the file is empty: build the index again");
    assert_snapshot!(opening(b"P5 640 480 255 and so on"), @"not a grasp index: build one with `grasp-builder build --out FILE`");
    assert_snapshot!(opening(&small()[..40]), @"truncated: 64 bytes expected, 40 found: copy or build the file again");
    let cut = opening(&small()[..9000]).replace(&small().len().to_string(), "ALL");
    assert_snapshot!(cut, @"truncated: ALL bytes expected, 9000 found: copy or build the file again");
    let folder = tempfile::tempdir().expect("a folder");
    assert_snapshot!(Index::open(folder.path()).expect_err("a folder"), @"it is a folder: name the index file itself");
    assert_snapshot!(Index::read(folder.path().join("none")).expect_err("no such file"), @"cannot read it");
    assert_snapshot!(Index::open("/dev/null").expect_err("a device"), @"it is not a regular file: copy it into one first");
}

#[test]
fn of_an_index_from_a_newer_version() {
    let mut bytes = small();
    bytes[8] = 8;
    let hash = xxh3_64(&bytes[..56]);
    bytes[56..64].copy_from_slice(&hash.to_le_bytes());
    assert_snapshot!(opening(&bytes), @"needs a reader of version 8 or later, and this one is of version 7: use a newer grasp-query, or build the file again with this grasp-builder");
}

#[test]
fn of_changed_bytes() {
    let mut header = small();
    header[20] ^= 1;
    assert_snapshot!(opening(&header), @"corrupt: the header does not match its hash: copy or build the file again");
    let mut catalogue = small();
    let last = catalogue.len() - 100;
    catalogue[last] ^= 1;
    assert_snapshot!(opening(&catalogue), @"corrupt: the catalogue does not match its hash: copy or build the file again");
    let mut descriptor = small();
    let index = Index::from_bytes(&descriptor).expect("the index opens");
    let sections = &index.catalogue().sections;
    let at = sections
        .iter()
        .find(|s| s.kind == grasp_index::SectionKind::Descriptors)
        .expect("there are descriptors");
    descriptor[at.offset as usize + 5] ^= 1;
    let problems = Index::from_bytes(&descriptor).expect("opening reads no section").verify().problems;
    assert_eq!(problems.len(), 1);
    assert_snapshot!(problems[0], @"corrupt: the section Descriptors does not match its hash: copy or build the file again");
}

#[test]
fn of_queries_that_do_not_fit() {
    let index = Index::from_bytes(&small()).expect("the index opens");
    let search = |query: &[f32], k| {
        let options = SearchOptions { k, ..SearchOptions::default() };
        index.search(query, &options).expect_err("the query does not fit").to_string()
    };
    assert_snapshot!(search(&[0.0; 300], 10), @"the query has 300 values, the index's descriptors have 340: describe pictures with the index's own parameters");
    assert_snapshot!(search(&[f32::NAN; 340], 10), @"value 0 of the query is not a finite number");
    assert_snapshot!(search(&[0.0; 340], 0), @"k is 0: ask for at least one neighbour");
    assert_snapshot!(index.entry(36).expect_err("one past the end"), @"there is no entry 36: the index holds 36, counted from 0");
}

#[test]
fn of_entries_that_do_not_fit() {
    let mut writer = IndexWriter::new(support::params(2)).expect("the parameters are sound");
    let good = NewEntry { file: "a.png".into(), descriptor: vec![0.0; 340], ..NewEntry::default() };
    let mut refused = |entry| writer.push(entry).expect_err("the entry does not fit").to_string();
    assert_snapshot!(refused(NewEntry { class: 2, ..good.clone() }), @"the entry a.png cannot be added: its class is number 2, and the index has 2");
    assert_snapshot!(refused(NewEntry { descriptor: vec![0.0; 339], ..good.clone() }), @"the entry a.png cannot be added: its descriptor has 339 values, the index's have 340");
    assert_snapshot!(refused(NewEntry { descriptor: vec![f32::NAN; 340], ..good.clone() }), @"the entry a.png cannot be added: value 0 of its descriptor is not a finite number");
    assert_snapshot!(refused(NewEntry { thumbnail: Some(vec![1]), ..good.clone() }), @"the entry a.png cannot be added: its thumbnail is not of the size of the index's own (1 and 0 pixels)");
    assert_snapshot!(refused(NewEntry { roll_deg: f32::NAN, ..good.clone() }), @"the entry a.png cannot be added: its view is not made of finite numbers");
    let twice = UnitQuaternion::new_unchecked(2.0 * UnitQuaternion::identity().into_inner());
    assert_snapshot!(refused(NewEntry { orientation: twice, ..good.clone() }), @"the entry a.png cannot be added: its orientation is not a unit quaternion");
    let huge = |value| NewEntry { descriptor: vec![value; 340], ..good.clone() };
    assert_snapshot!(refused(huge(-2e15)), @"the entry a.png cannot be added: value 0 of its descriptor is beyond 1e15: divide all descriptors by the same number");
    assert!(matches!(writer.finish_bytes(), Err(BuildError::Empty)));
    let halves = IndexParams { originals: Originals::F16, hash: HashParams::Learned, ..support::params(2) };
    let mut writer = IndexWriter::new(halves).expect("the parameters are sound");
    writer.push(huge(65_504.0)).expect("the most that 16 bits hold");
    assert_snapshot!(writer.push(huge(-70_000.0)).expect_err("more than 16 bits hold"), @"the entry a.png cannot be added: value 0 of its descriptor is too large for 16 bits: keep the originals as f32");
    let none = IndexWriter::new(IndexParams::default()).expect_err("no classes");
    assert_snapshot!(none, @"an index needs at least one class, one hand shape and one stage");
}

#[test]
fn of_parameters_that_make_no_index() {
    let refused = |spoil: fn(&mut IndexParams)| {
        let mut params = IndexParams { descriptor: DescriptorParams::raw(4), ..support::small_params() };
        spoil(&mut params);
        IndexWriter::new(params).expect_err("the parameters are out of range").to_string()
    };
    assert_snapshot!(refused(|p| p.descriptor = DescriptorParams::raw(0)), @"vectors of 0 values: 1 to 65,536 are supported");
    let unnamed: [fn(&mut IndexParams); 3] =
        [|p| p.classes.clear(), |p| p.hand_shapes.clear(), |p| p.stages.clear()];
    allow_duplicates! {
        for unnamed in unnamed {
            assert_snapshot!(refused(unnamed), @"an index needs at least one class, one hand shape and one stage");
        }
    }
    let many: [fn(&mut IndexParams); 3] = [
        |p| p.classes.resize(65_537, p.classes[0].clone()),
        |p| p.hand_shapes.resize(65_537, "mean".into()),
        |p| p.stages.resize(257, "grasp".into()),
    ];
    allow_duplicates! {
        for many in many {
            assert_snapshot!(refused(many), @"at most 65,536 classes, 65,536 hand shapes and 256 stages can be numbered");
        }
    }
    assert_snapshot!(refused(|p| p.thumbnail_side = 1025), @"a thumbnail has at most 1024 pixels a side");
    assert_snapshot!(refused(|p| p.calibration = Calibration { k: 0, ..p.calibration }), @"a calibration needs at least one neighbour, positive factors, and a floor and thresholds of 0 or more");
    let hashes = [(0, 1, 1), (65, 1, 1), (1, 0, 1), (1, 1025, 1), (1, 1, 0), (1, 1, (1 << 20) + 1)];
    allow_duplicates! {
        for (k, t, buckets) in hashes {
            let hash = HashParams::Random(RandomParams::Fixed { k, t, buckets });
            let params = IndexParams { hash, ..support::small_params() };
            assert_snapshot!(IndexWriter::new(params).expect_err("no such hash"), @"K must be 1 to 64, T 1 to 1024, and H 1 to 1,048,576");
        }
    }
    assert_snapshot!(refused(|p| p.originals = Originals::F16), @"a random hash needs the original descriptors as they are (f32)");
    assert_snapshot!(refused(|p| (p.descriptor, p.hash) = (DescriptorParams::raw(4097), HashParams::Learned)), @"a learned hash takes vectors of at most 4,096 values: reduce them first, or take a random hash");
}

#[test]
fn of_rows_that_cannot_be_held_out() {
    let refused = |held_out: Vec<f32>, held_out_classes: Vec<u16>, kept| {
        let descriptor = DescriptorParams::raw(4);
        let params = IndexParams { descriptor, held_out, held_out_classes, kept, ..support::small_params() };
        IndexWriter::new(params).expect_err("the rows do not fit").to_string()
    };
    let all = support::small_params().kept;
    assert_snapshot!(refused(vec![0.0; 7], vec![], all), @"the held-out descriptors must be as long as the index's own");
    assert_snapshot!(refused(vec![0.0, 0.0, f32::NAN, 0.0], vec![], all), @"the held-out descriptors must be made of finite numbers, none beyond 1e15");
    assert_snapshot!(refused(vec![0.0, 0.0, -2e15, 0.0], vec![], all), @"the held-out descriptors must be made of finite numbers, none beyond 1e15");
    assert_snapshot!(refused(vec![0.0; 8], vec![0], all), @"held-out classes need a held-out descriptor each, and an index with labels");
    assert_snapshot!(refused(vec![0.0; 8], vec![0, 3], all), @"the held-out descriptors must be of the index's classes");
    assert_snapshot!(refused(vec![0.0; 4], vec![0], KeptFields::nothing()), @"held-out classes need a held-out descriptor each, and an index with labels");
}

#[test]
fn of_paths_that_cannot_be_written() {
    let write = |path: &Path| support::write_small(path).expect_err("the path cannot be written").to_string();
    assert_snapshot!(write(Path::new("/nowhere/at/all.idx")), @"there is no folder /nowhere/at: create it first");
    assert_snapshot!(write(Path::new("/dev/null")), @"/dev/null is not a regular file: name the file to write");
    let folder = tempfile::tempdir().expect("a folder");
    let message = write(folder.path()).replace(&*folder.path().to_string_lossy(), "FOLDER");
    assert_snapshot!(message, @"FOLDER is not a regular file: name the file to write");
}

#[test]
fn of_pictures_without_a_hand() {
    let message =
        |result: Result<HandImage, grasp_index::HandImageError>| result.expect_err("no hand").to_string();
    assert_snapshot!(message(HandImage::from_segmented(20, 10, &[0; 200], 0)), @"no hand found: no pixel of the 20 x 10 picture belongs to a hand");
    assert_snapshot!(message(HandImage::from_segmented(20, 10, &[0; 199], 0)), @"a 20 x 10 picture needs 200 values, but grey holds 199");
    assert_snapshot!(message(HandImage::from_mask(20, 10, &[9; 199], &[1; 200])), @"a 20 x 10 picture needs 200 values, but grey holds 199");
    assert_snapshot!(message(HandImage::from_mask(20, 10, &[9; 200], &[])), @"a 20 x 10 picture needs 200 values, but mask holds 0");
    assert_snapshot!(message(HandImage::from_segmented(20, 4, &[9; 80], 0)), @"the hand is 20 x 4 pixels; at least 8 x 8 are needed: move closer or use a larger picture");
}
