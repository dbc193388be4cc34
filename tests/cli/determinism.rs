//! Same inputs and seed, same bytes: at any thread count, by way of pictures on disk or not, built
//! anew or onto an old index.

use std::fs;
use std::path::Path;

use grasp_tests::{program, run};

fn build(arguments: &[&str], out: &Path) -> Vec<u8> {
    let outcome = run(program("grasp-builder").arg("build").args(arguments).arg("--out").arg(out));
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    fs::read(out).unwrap()
}

#[test]
fn thread_counts_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let one = build(&["--step", "30", "--threads", "1"], &folder.path().join("one.idx"));
    let two = build(&["--step", "30", "--threads", "2"], &folder.path().join("two.idx"));
    assert!(one == two, "indexes built by 1 and by 2 threads differ");
    let other_seed = build(&["--step", "30", "--seed", "8"], &folder.path().join("seed.idx"));
    assert!(one != other_seed, "the seed has no effect");
}

#[test]
fn growing_an_index_gives_the_bytes_of_a_build_from_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    for (set, shape) in [(&first, "mean"), (&second, "slender")] {
        let rendered = run(program("grasp-builder")
            .args(["render", "--step", "36", "--hand-shape", shape, "--out"])
            .arg(set));
        assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    }
    let (first, second) = (first.to_str().unwrap(), second.to_str().unwrap());
    for descriptor in ["default", "upright"] {
        let as_named = ["--descriptor", descriptor];
        let grown = folder.path().join(format!("{descriptor}.idx"));
        let small = build(&[&as_named[..], &[first]].concat(), &grown);
        assert!(
            small == build(&[&as_named[..], &[first]].concat(), &grown),
            "building again changes the file"
        );

        let both = [&as_named[..], &[first, second]].concat();
        let after = build(&both, &grown);
        let fresh = build(&both, &folder.path().join("fresh.idx"));
        assert!(
            after == fresh,
            "{descriptor}: an index grown by a render set differs from one built from nothing"
        );
        assert!(after.len() > small.len());
    }
}

#[test]
fn a_changed_roll_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let rendered = run(program("grasp-builder").args(["render", "--step", "45", "--out"]).arg(&set));
    assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    let upright = ["--descriptor", "upright", set.to_str().unwrap()];
    let index = folder.path().join("grasp.idx");
    let before = build(&upright, &index);

    let manifest = set.join("manifest.csv");
    let mut reader = csv::Reader::from_path(&manifest).unwrap();
    let headers = reader.headers().unwrap().clone();
    let roll = headers.iter().position(|header| header == "roll").unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let mut writer = csv::Writer::from_path(&manifest).unwrap();
    writer.write_record(&headers).unwrap();
    for row in rows {
        writer
            .write_record(row.iter().enumerate().map(|(at, v)| if at == roll { "12.3" } else { v }))
            .unwrap();
    }
    writer.flush().unwrap();

    let after = build(&upright, &index);
    assert!(after != before, "the changed roll went unnoticed");
    assert!(
        after == build(&upright, &folder.path().join("fresh.idx")),
        "differs from one built from nothing"
    );
}

#[test]
fn a_changed_picture_is_described_anew() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let rendered = run(program("grasp-builder").args(["render", "--step", "45", "--out"]).arg(&set));
    assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    let index = folder.path().join("grasp.idx");
    let before = build(&[set.to_str().unwrap()], &index);

    let mut manifest = csv::Reader::from_path(set.join("manifest.csv")).unwrap();
    let picture = set.join(&manifest.records().next().unwrap().unwrap()[0]);
    image::open(&picture).unwrap().fliph().save(&picture).unwrap();

    let after = build(&[set.to_str().unwrap()], &index);
    let fresh = build(&[set.to_str().unwrap()], &folder.path().join("fresh.idx"));
    assert!(after != before, "the changed picture went unnoticed");
    assert!(after == fresh, "the rebuilt index differs from one built from nothing");
}
