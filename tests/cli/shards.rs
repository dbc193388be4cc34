//! Parts made apart and merged are the index that one machine builds: `shard` and `merge`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use grasp_tests::{Outcome, program, run};

const HANDS: [&str; 4] = ["--step", "45", "--hands", "3"];

fn builder(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program("grasp-builder");
    command.args(arguments).current_dir(folder);
    command
}

fn done(folder: &Path, arguments: &[&str]) -> Outcome {
    let outcome = run(&mut builder(folder, arguments));
    assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
    outcome
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let outcome = run(&mut builder(folder, arguments));
    assert_eq!(outcome.status, 2, "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
    outcome.stderr
}

fn shards(folder: &Path, of: u32, options: &[&str]) {
    for shard in 1..=of {
        let share = format!("{shard}/{of}");
        done(folder, &[&["shard", "--shard", &share, "--out", "parts"], options].concat());
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// That building at once and merging `of` parts give the same bytes.
fn assert_same(folder: &Path, of: u32, options: &[&str]) {
    done(folder, &[&["build", "--out", "single.idx"], options].concat());
    shards(folder, of, options);
    done(folder, &["merge", "parts", "--out", "merged.idx", "--threads", "1"]);
    assert!(
        fs::read(folder.join("single.idx")).unwrap() == fs::read(folder.join("merged.idx")).unwrap(),
        "{options:?}: merged from {of} parts, the index has other bytes"
    );
    for name in ["single.idx", "merged.idx"] {
        fs::remove_file(folder.join(name)).unwrap();
    }
    fs::remove_dir_all(folder.join("parts")).unwrap();
}

#[test]
fn merged_parts_have_the_bytes_of_a_single_build() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_same(folder, 3, &HANDS);
    assert_same(folder, 5, &["--step", "60", "--hands", "2", "--originals", "f16", "--thumbnails", "0"]);
    assert_same(folder, 4, &["--step", "60", "--hash", "random", "--tables", "3", "--planes", "6"]);
    assert_same(folder, 2, &["--preset", "wide", "--hands", "1", "--views", "2"]);
}

#[test]
fn sets_and_vectors_are_split_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (set, shape) in [("one", "mean"), ("two", "slender")] {
        done(folder, &["render", "--step", "60", "--hand-shape", shape, "--out", set]);
    }
    assert_same(folder, 3, &["one", "two"]);
    done(folder, &["build", "one", "--out", "a.idx"]);
    done(folder, &["export", "a.idx", "--descriptors", "x.npy", "--labels", "y.csv"]);
    assert_same(folder, 4, &["--descriptors", "x.npy"]);
    let labelled = ["--descriptors", "x.npy", "--labels", "y.csv", "--descriptor", "default"];
    assert_same(folder, 4, &[&labelled[..], &["--held-out", "x.npy"]].concat());
}

#[test]
fn a_part_that_is_there_is_left_alone_and_another_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shard = ["shard", "--shard", "2/3", "--out", "parts"];
    let make = |more: &[&str]| done(folder, &[&shard[..], &HANDS, more].concat()).stdout;
    let path = folder.join("parts/2-of-3.shard");
    assert!(!make(&[]).contains("up to date"));
    let (bytes, written) = (fs::read(&path).unwrap(), fs::metadata(&path).unwrap().modified().unwrap());
    assert!(make(&["--threads", "1"]).contains("is up to date"));
    assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), written);

    // Other options, and bytes that have changed.
    assert!(!make(&["--light-variation", "0.1"]).contains("up to date"));
    assert!(fs::read(&path).unwrap() != bytes);
    for spoil in [bytes.len() / 2, bytes.len() - 1, 100, 9] {
        let mut spoiled = bytes.clone();
        spoiled[spoil] ^= 4;
        fs::write(&path, spoiled).unwrap();
        assert!(!make(&[]).contains("up to date"), "byte {spoil}");
        assert!(fs::read(&path).unwrap() == bytes);
    }
    fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
    assert!(!make(&[]).contains("up to date"));
    assert_eq!(names(&folder.join("parts")), ["2-of-3.shard"]);
}

#[test]
fn a_killed_worker_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let options = ["--step", "20", "--hands", "2"];
    done(folder, &[&["build", "--out", "single.idx"], &options[..]].concat());
    let parts: PathBuf = folder.join("parts");
    let mut worker = builder(folder, &["shard", "--shard", "1/2", "--out", "parts"]);
    let mut worker = worker.args(options).stdout(Stdio::null()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while !parts.join(".1-of-2.shard.part").exists() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    worker.kill().unwrap();
    worker.wait().unwrap();
    shards(folder, 2, &options);
    done(folder, &["merge", "parts", "--out", "merged.idx"]);
    assert!(fs::read(folder.join("single.idx")).unwrap() == fs::read(folder.join("merged.idx")).unwrap());
    assert_eq!(names(&parts), ["1-of-2.shard", "2-of-2.shard"]);
}

#[test]
fn parts_that_make_no_index_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("parts")).unwrap();
    assert!(refused(folder, &["merge", "parts"]).contains("there are no parts in parts"));
    assert!(refused(folder, &["merge", "none"]).contains("cannot read the folder none"));
    shards(folder, 3, &HANDS);
    let (second, third) = (folder.join("parts/2-of-3.shard"), folder.join("parts/3-of-3.shard"));
    let bytes = fs::read(&second).unwrap();

    fs::remove_file(&second).unwrap();
    let said = refused(folder, &["merge", "parts"]);
    assert!(said.contains("has 2 of 3 parts; missing: 2: run `grasp-builder shard --shard I/3`"), "{said}");

    for (spoiled, says) in [
        (bytes[..bytes.len() / 2].to_vec(), "truncated"),
        (b"P5 640 480 ".to_vec(), "not a part of an index"),
        ([&bytes[..], b"more"].concat(), "damaged"),
        ([&bytes[..bytes.len() - 40], &[7], &bytes[bytes.len() - 39..]].concat(), "damaged"),
    ] {
        fs::write(&second, spoiled).unwrap();
        let said = refused(folder, &["merge", "parts"]);
        assert!(said.contains("2-of-3.shard cannot be used") && said.contains(says), "{says}: {said}");
    }
    // Of another index, by its parameters or by its number.
    fs::remove_file(&second).unwrap();
    let shard = ["shard", "--shard", "2/3", "--out", "parts"];
    done(folder, &[&shard[..], &HANDS, &["--seed", "8"]].concat());
    assert!(refused(folder, &["merge", "parts"]).contains("parts of different indexes"));
    fs::write(&second, &bytes).unwrap();
    fs::copy(&third, folder.join("parts/again.shard")).unwrap();
    let said = refused(folder, &["merge", "parts"]);
    assert!(
        said.contains("again.shard are the same part") || said.contains("3-of-3.shard are the same part"),
        "{said}"
    );
    assert!(!folder.join("grasp.idx").exists());

    assert!(refused(folder, &["shard", "--shard", "4/3", "--out", "p"]).contains("does not name a part"));
    let said = refused(folder, &["shard", "--shard", "1/7", "--preset", "paper", "--out", "p"]);
    assert!(said.contains("there are 6 scenes, pictures or rows, too few for"), "{said}");
}
