//! `grasp-builder experiment scale`: a table and a picture, gone on with where it was stopped.

use std::fs;
use std::path::Path;

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_tests::{Outcome, program, run};

const DIM: u64 = 84;

/// Rows around a few centres, from a small generator of its own: the test needs no more than that
/// they differ.
fn write_rows(path: &Path, rows: u64, seed: u64) {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut bytes = NpyHeader { element: NpyType::F32, rows, columns: DIM, offset: 0 }.to_bytes();
    for row in 0..rows {
        let centre = (row % 7) as f32 / 7.0;
        let values =
            (0..DIM).map(|axis| if axis % 7 == row % 7 { centre + 0.3 * next() } else { 0.1 * next() });
        bytes.extend(values.flat_map(f32::to_le_bytes));
    }
    fs::write(path, bytes).unwrap();
}

fn scale(folder: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-builder")
        .args(["experiment", "scale", "--descriptors", "x.npy", "--queries", "q.npy", "--out", "results"])
        .args(arguments)
        .current_dir(folder))
}

#[test]
fn sizes_are_measured_once_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    write_rows(&folder.path().join("x.npy"), 1500, 1);
    write_rows(&folder.path().join("q.npy"), 40, 2);
    let first = scale(folder.path(), &["--sizes", "300"]);
    assert_eq!(first.status, 0, "{}", first.stderr);
    assert!(first.stderr.contains("300 entries"), "{}", first.stderr);

    let results = folder.path().join("results");
    let before = fs::read_to_string(results.join("scale.csv")).unwrap();
    let second = scale(folder.path(), &["--sizes", "300,1500"]);
    assert_eq!(second.status, 0, "{}", second.stderr);
    assert!(
        !second.stderr.contains(" 300 entries") && second.stderr.contains("1500 entries"),
        "{}",
        second.stderr
    );
    assert!(second.stdout.contains("candidates grow with N^"), "{}", second.stdout);

    let mut table = csv::Reader::from_path(results.join("scale.csv")).unwrap();
    let headers = table.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let (entries, success, share) = (column("entries"), column("eps_success"), column("share_of_database"));
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    for row in &rows {
        assert!(["300", "1500"].contains(&&row[entries]));
        let (success, share): (f64, f64) = (row[success].parse().unwrap(), row[share].parse().unwrap());
        assert!((0.5..=1.0).contains(&success) && share > 0.0 && share <= 1.0, "{row:?}");
    }
    for line in before.lines() {
        assert!(
            fs::read_to_string(results.join("scale.csv")).unwrap().contains(line),
            "{line} was measured anew"
        );
    }
    let svg = fs::read_to_string(results.join("scale.svg")).unwrap();
    assert_eq!(svg.matches("<circle").count(), 2 * 6 * rows.len());
    fs::remove_file(results.join("scale.svg")).unwrap();
    let mut redraw = program("grasp-builder");
    redraw.args(["experiment", "scale", "--redraw", "--out"]).arg(&results);
    let redrawn = run(&mut redraw);
    assert_eq!((redrawn.status, &*redrawn.stderr), (0, ""));
    assert!(redrawn.stdout.contains("candidates grow with N^"), "{}", redrawn.stdout);
    assert_eq!(fs::read_to_string(results.join("scale.svg")).unwrap(), svg);
    let mut left: Vec<_> = fs::read_dir(&results).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["scale.csv", "scale.svg"]);
}

#[test]
fn what_cannot_be_measured_is_told() {
    let folder = tempfile::tempdir().unwrap();
    write_rows(&folder.path().join("x.npy"), 200, 1);
    write_rows(&folder.path().join("q.npy"), 5, 2);
    let too_many = scale(folder.path(), &["--sizes", "150,1000"]);
    assert!(
        too_many.status == 2 && too_many.stderr.contains("holds 200 rows, and 1000 are wanted"),
        "{}",
        too_many.stderr
    );
    assert!(!folder.path().join("results/scale.csv").exists(), "nothing is measured first");
    // Without sizes, as many as there are.
    let measured = scale(folder.path(), &[]);
    assert_eq!(measured.status, 0, "{}", measured.stderr);
    let other = scale(folder.path(), &["--sizes", "200", "--seed", "8"]);
    assert!(other.status == 2 && other.stderr.contains("results of other data"), "{}", other.stderr);
    fs::write(folder.path().join("results/scale.csv"), "a,b\n1,2\n").unwrap();
    let foreign = scale(folder.path(), &["--sizes", "200"]);
    assert!(
        foreign.status == 2 && foreign.stderr.contains("is not a table of this experiment"),
        "{}",
        foreign.stderr
    );
}
