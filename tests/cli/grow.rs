//! Indexes that change: `add`, `remove` and `compact` make what a build of the same entries from
//! nothing makes.

use std::fs;
use std::path::Path;

use grasp_index::{Index, Section};
use grasp_tests::{Outcome, program, run, workspace};

fn builder(folder: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-builder").args(arguments).current_dir(folder))
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let outcome = builder(folder, arguments);
    assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
    outcome.stdout
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let outcome = builder(folder, arguments);
    assert_eq!(outcome.status, 2, "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
    outcome.stderr
}

/// That two indexes are the same in everything but where they say they come from: every section, to
/// the last bit, and all that was measured.
fn assert_same(folder: &Path, one: &str, other: &str) {
    let [one, other] = [one, other].map(|name| Index::open(folder.join(name)).unwrap());
    assert!(one.verify().is_sound());
    let (a, b) = (one.catalogue(), other.catalogue());
    let bytes =
        |sections: &[Section]| sections.iter().map(|s| (s.kind, s.length, s.xxh3)).collect::<Vec<_>>();
    assert_eq!(a.hand_shapes, b.hand_shapes);
    assert_eq!(bytes(&a.sections), bytes(&b.sections));
    assert_eq!((&a.measured, &a.calibration, &a.sigma), (&b.measured, &b.calibration, &b.sigma));
    assert_eq!((&a.classes, &a.stages, a.entries), (&b.classes, &b.stages, b.entries));
}

#[test]
fn a_grown_index_answers_as_one_built_from_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (set, shape) in [("one", "mean"), ("two", "slender")] {
        done(folder, &["render", "--step", "45", "--hand-shape", shape, "--out", set]);
    }
    done(folder, &["build", "one", "two", "--out", "both.idx"]);
    done(folder, &["build", "one", "--out", "one.idx"]);
    fs::copy(folder.join("one.idx"), folder.join("grown.idx")).unwrap();

    let said = done(folder, &["add", "grown.idx", "two", "--threads", "1"]);
    assert!(said.contains("reused"), "{said}");
    assert_same(folder, "grown.idx", "both.idx");
    // What is there already is not added twice.
    done(folder, &["add", "grown.idx", "two", "one"]);
    assert_same(folder, "grown.idx", "both.idx");

    fs::copy(folder.join("one.idx"), folder.join("twice.idx")).unwrap();
    done(folder, &["add", "twice.idx", "two", "two"]);
    assert_same(folder, "twice.idx", "both.idx");

    // A segment of its own, which leaves the index alone until both become one.
    let before = fs::read(folder.join("one.idx")).unwrap();
    done(folder, &["add", "one.idx", "two", "--segment", "two.idx"]);
    assert!(fs::read(folder.join("one.idx")).unwrap() == before);
    // What the index has is in no segment beside it.
    let said = refused(folder, &["add", "one.idx", "one", "--segment", "again.idx"]);
    assert!(said.contains("the index holds all of these pictures"), "{said}");
    done(folder, &["compact", "one.idx", "two.idx", "--out", "one.idx"]);
    assert_same(folder, "one.idx", "both.idx");

    done(folder, &["remove", "grown.idx", "--hand-shape", "mean"]);
    done(folder, &["build", "two", "--out", "two.idx"]);
    assert_same(folder, "grown.idx", "two.idx");
    let said = refused(folder, &["remove", "grown.idx", "--hand-shape", "mean"]);
    assert!(said.contains("there is no hand shape mean in the index"), "{said}");
    let said = refused(folder, &["remove", "grown.idx", "--hand-shape", "slender"]);
    assert!(said.contains("nothing to index"), "{said}");
    assert_same(folder, "grown.idx", "two.idx");
}

#[test]
fn hand_shapes_are_added_as_they_are_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let views = ["--step", "60"];
    done(
        folder,
        &[&["build", "--hand-shape", "mean", "--hand-shape", "broad", "--out", "both.idx"], &views[..]]
            .concat(),
    );
    done(folder, &[&["build", "--hand-shape", "mean", "--out", "grown.idx"], &views[..]].concat());
    fs::copy(folder.join("grown.idx"), folder.join("again.idx")).unwrap();
    done(folder, &[&["add", "grown.idx", "--hand-shape", "broad"], &views[..]].concat());
    assert_same(folder, "grown.idx", "both.idx");
    // The index knows by itself how its hands are seen.
    done(folder, &["add", "again.idx", "--hand-shape", "broad"]);
    assert_same(folder, "again.idx", "both.idx");
}

#[test]
fn an_index_knows_how_its_hands_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let seen = ["--stage", "reach", "--step", "90", "--forearm", "30"];
    let build = |out: &str, hands: &[&str]| {
        let hands = hands.iter().flat_map(|hand| ["--hand-shape", hand]);
        done(folder, &[&["build", "--out", out], &seen[..], &hands.collect::<Vec<_>>()].concat());
    };
    build("mean.idx", &["mean"]);
    build("both.idx", &["mean", "slender"]);
    let inspected = done(folder, &["inspect", "both.idx"]);
    let spec = r#"{"version":1,"preset":"paper","stages":["reach"],"step_deg":90.0,"forearm_mm":30.0}"#;
    assert!(inspected.contains(spec), "{inspected}");

    let copied = |name: &str| fs::copy(folder.join(name), folder.join("grown.idx")).unwrap();
    copied("mean.idx");
    done(folder, &["add", "grown.idx", "--hand-shape", "slender"]);
    assert_same(folder, "grown.idx", "both.idx");
    done(folder, &["remove", "grown.idx", "--hand-shape", "slender"]);
    assert_same(folder, "grown.idx", "mean.idx");
    done(folder, &["add", "mean.idx", "--hand-shape", "slender", "--segment", "slender.idx"]);
    let joined = builder(folder, &["compact", "mean.idx", "slender.idx", "--out", "joined.idx"]);
    assert_eq!((joined.status, joined.stderr.as_str()), (0, ""));
    assert_same(folder, "joined.idx", "both.idx");
    // And says so of what came of it.
    assert!(done(folder, &["inspect", "joined.idx"]).contains(spec));
}

#[test]
fn indexes_of_every_release_grow_and_say_what_they_do_not_know() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["v2.idx", "v2-learned.idx", "v3.idx", "v3-learned.idx", "v4.idx", "v4-learned.idx"] {
        fs::copy(workspace().join("index/tests/fixtures").join(name), folder.join(name)).unwrap();
        let outcome = builder(folder, &["compact", name, "--out", "new.idx"]);
        assert_eq!(outcome.status, 0, "{name}: {}", outcome.stderr);
        let says =
            format!("{name} does not say how its hands are seen: it is taken to be as in the paper's preset");
        assert!(outcome.stderr.contains(&says), "{}", outcome.stderr);
        let [old, new] = [name, "new.idx"].map(|name| Index::open(folder.join(name)).unwrap());
        assert!(new.verify().is_sound());
        assert_eq!(
            (new.len(), new.catalogue().hand_shapes.clone()),
            (old.len(), old.catalogue().hand_shapes.clone())
        );
        if name == "v3.idx" {
            // From now on it says so.
            let again = builder(folder, &["compact", "new.idx", "--out", "new.idx"]);
            assert_eq!((again.status, again.stderr.as_str()), (0, ""));
            let both = builder(folder, &["compact", "new.idx", name, "--out", "both.idx"]);
            assert_eq!(both.status, 0, "{}", both.stderr);
            assert!(both.stderr.contains("are seen in different ways"), "{}", both.stderr);
        }
    }
}

#[test]
fn indexes_that_do_not_go_together_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let build =
        |out: &str, more: &[&str]| done(folder, &[&["build", "--step", "60", "--out", out], more].concat());
    build("a.idx", &[]);
    build("paper.idx", &["--descriptor", "paper"]);
    build("small.idx", &["--thumbnails", "16"]);
    build("none.idx", &["--originals", "none"]);
    let before = fs::read(folder.join("a.idx")).unwrap();
    for (other, says) in [
        ("paper.idx", "differs from the first index in how pictures are described"),
        ("small.idx", "the size of its thumbnails"),
        ("none.idx", "keeps no descriptors to take over"),
        ("missing.idx", "cannot use the index missing.idx"),
    ] {
        let said = refused(folder, &["compact", "a.idx", other, "--out", "a.idx"]);
        assert!(said.contains(says), "{other}: {said}");
    }
    let mut spoiled = before.clone();
    spoiled[before.len() / 2] ^= 1;
    fs::write(folder.join("b.idx"), spoiled).unwrap();
    assert!(refused(folder, &["compact", "a.idx", "b.idx"]).contains("b.idx is damaged"));
    assert!(fs::read(folder.join("a.idx")).unwrap() == before);

    done(folder, &["export", "a.idx", "--descriptors", "x.npy"]);
    done(folder, &["build", "--descriptors", "x.npy", "--out", "raw.idx"]);
    assert!(refused(folder, &["add", "raw.idx", "--hand-shape", "broad"]).contains("cannot be added"));
    fs::copy(folder.join("raw.idx"), folder.join("copy.idx")).unwrap();
    done(folder, &["compact", "raw.idx", "copy.idx", "--out", "twice.idx"]);
    assert_eq!(
        Index::open(folder.join("twice.idx")).unwrap().len(),
        2 * Index::open(folder.join("raw.idx")).unwrap().len()
    );
}

#[test]
fn an_index_remembers_its_grasps_and_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let grasps = fs::read_to_string(workspace().join("renders/data/grasps.toml")).unwrap();
    fs::write(folder.join("own.toml"), grasps.replace("\"large-diameter\"", "\"bottle\"")).unwrap();
    let few = ["--preset", "paper", "--step", "90", "--grasps", "own.toml"];
    done(folder, &[&["build", "--out", "own.idx", "--hand-shape", "mean"][..], &few].concat());
    done(folder, &["add", "own.idx", "--hand-shape", "slender"]);
    let both = ["--hand-shape", "mean", "--hand-shape", "slender"];
    done(folder, &[&["build", "--out", "both.idx"][..], &both, &few].concat());
    assert_same(folder, "own.idx", "both.idx");
    let said = done(folder, &["inspect", "own.idx"]);
    assert!(said.contains(" 1 bottle") && !said.contains("large-diameter: "), "{said}");
    // Nor are they forgotten where nothing is added.
    done(folder, &["remove", "own.idx", "--hand-shape", "slender"]);
    done(folder, &["add", "own.idx", "--hand-shape", "slender"]);
    assert_same(folder, "own.idx", "both.idx");

    let before = fs::read(folder.join("own.idx")).unwrap();
    let said = refused(folder, &["add", "own.idx", "--hand-shape", "broad", "--segment", "./own.idx"]);
    assert!(said.contains("--segment names the index itself"), "{said}");
    let said = refused(folder, &["compact", "own.idx", "./own.idx", "--out", "twice.idx"]);
    assert!(said.contains("is named twice"), "{said}");
    fs::rename(folder.join("own.idx"), folder.join("1-of-2.idx")).unwrap();
    let said = refused(folder, &["split", "1-of-2.idx", "--segments", "2", "--out-dir", "."]);
    assert!(said.contains("would be written over"), "{said}");
    assert!(fs::read(folder.join("1-of-2.idx")).unwrap() == before);
}
