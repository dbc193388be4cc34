//! `grasp-query search`: raw descriptors in, the numbers of the nearest entries out.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use grasp_index::Index;
use grasp_index::npy::{NpyHeader, NpyType};
use grasp_tests::{Outcome, program, run, run_with_input, small_index};

/// Values of a descriptor of the small index.
const DIM: usize = 340;

fn descriptors() -> Vec<Vec<f32>> {
    let index = Index::open(small_index()).unwrap();
    (0..index.len() as u32).map(|id| index.descriptor(id).unwrap().to_vec()).collect()
}

/// Rows of the index, each moved a little along the difference of two others.
fn queries(count: usize) -> Vec<f32> {
    let rows = descriptors();
    let row = |at: usize| &rows[at % rows.len()];
    (0..count)
        .flat_map(|n| {
            let (from, to) = (row(n * 31 + 7), row(n * 17 + 5));
            let moved =
                row(n * 13).iter().zip(from).zip(to).map(|((value, from), to)| value + 0.2 * (to - from));
            moved.collect::<Vec<f32>>()
        })
        .collect()
}

fn array(values: &[f32], columns: usize) -> Vec<u8> {
    let rows = (values.len() / columns) as u64;
    let mut bytes = NpyHeader { element: NpyType::F32, rows, columns: columns as u64, offset: 0 }.to_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// The numbers of an array of `element`s as they lie in the file, by rows.
fn rows(bytes: &[u8], element: NpyType) -> Vec<Vec<[u8; 4]>> {
    let header = NpyHeader::read(&mut &bytes[..], element).unwrap();
    let values: Vec<[u8; 4]> =
        bytes[header.offset as usize..].chunks(4).map(|value| value.try_into().unwrap()).collect();
    assert_eq!(values.len() as u64, header.rows * header.columns);
    values.chunks(header.columns as usize).map(<[[u8; 4]]>::to_vec).collect()
}

fn ids(bytes: &[u8]) -> Vec<Vec<u32>> {
    let id_rows = rows(bytes, NpyType::U32);
    id_rows.into_iter().map(|row| row.into_iter().map(u32::from_le_bytes).collect()).collect()
}

fn distances(bytes: &[u8]) -> Vec<Vec<f32>> {
    let distance_rows = rows(bytes, NpyType::F32);
    distance_rows.into_iter().map(|row| row.into_iter().map(f32::from_le_bytes).collect()).collect()
}

/// A folder with `q.npy` in it.
fn folder(queries: &[f32]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("q.npy"), array(queries, DIM)).unwrap();
    folder
}

fn search(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program("grasp-query");
    command.args(["search", "--index"]).arg(small_index()).args(arguments).current_dir(folder);
    command
}

fn done(command: &mut Command) -> Outcome {
    let outcome = run(command);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    outcome
}

fn brute_force(query: &[f32], entries: &[Vec<f32>]) -> Vec<(f64, u32)> {
    let squared = |row: &Vec<f32>| -> f64 {
        row.iter().zip(query).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
    };
    let mut all: Vec<(f64, u32)> =
        entries.iter().zip(0..).map(|(row, id)| (squared(row).sqrt(), id)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

#[test]
fn exact_search_is_brute_force_and_the_default_finds_most_of_it() {
    let queries = queries(60);
    let folder = folder(&queries);
    done(&mut search(folder.path(), &["q.npy", "--exact", "--out", "e.npy", "--distances", "d.npy"]));
    done(&mut search(folder.path(), &["q.npy", "--out", "found.npy"]));
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let (exact, found) = (ids(&read("e.npy")), ids(&read("found.npy")));
    let distances = distances(&read("d.npy"));
    let entries = descriptors();
    let mut met = 0;
    for (n, query) in queries.chunks(DIM).enumerate() {
        let truth = brute_force(query, &entries);
        assert_eq!(exact[n].len(), 10);
        for (place, (&id, &distance)) in exact[n].iter().zip(&distances[n]).enumerate() {
            // Rows at all but the same distance may change places.
            let true_distance = truth[place].0;
            let own = truth.iter().find(|(_, other)| *other == id).unwrap().0;
            assert!((f64::from(distance) - true_distance).abs() < 1e-5, "query {n}, place {place}");
            assert!((own - true_distance).abs() < 1e-5, "query {n}, place {place}");
        }
        met += found[n].iter().filter(|id| exact[n].contains(id)).count();
    }
    assert!(met >= 480, "{met} of 600 true neighbours were found");
}

#[test]
fn threads_pipes_and_rounds_give_the_same_answers() {
    let queries = queries(41);
    let folder = folder(&queries);
    let write = |name: &str, arguments: &[&str]| {
        done(&mut search(folder.path(), &[&["q.npy", "--out", name], arguments].concat()));
        fs::read(folder.path().join(name)).unwrap()
    };
    let one = write("1.npy", &["--threads", "1"]);
    assert!(one == write("2.npy", &["--threads", "2"]));
    assert!(one == write("7.npy", &["--threads", "7", "--rounds", "3"]));
    assert!(one == write("r.npy", &["--no-mmap"]));
    let mut piped = search(folder.path(), &["-", "--out", "-"]);
    let output = {
        use std::io::Write as _;
        use std::process::Stdio;
        let mut child = piped.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(&array(&queries, DIM)).unwrap();
        child.wait_with_output().unwrap()
    };
    assert!(output.status.success() && output.stdout == one);
}

#[test]
fn rows_are_filled_where_the_index_has_fewer_entries() {
    let folder = folder(&queries(2));
    let entries = descriptors().len();
    let k = (entries + 3).to_string();
    done(&mut search(folder.path(), &["q.npy", "--k", &k, "--out", "i.npy", "--distances", "d.npy"]));
    for row in ids(&fs::read(folder.path().join("i.npy")).unwrap()) {
        let mut found = row[..entries].to_vec();
        found.sort_unstable();
        assert!(found.into_iter().eq(0..entries as u32));
        assert_eq!(row[entries..], [u32::MAX; 3]);
    }
    for row in distances(&fs::read(folder.path().join("d.npy")).unwrap()) {
        assert!(row[..entries].is_sorted() && row[entries..] == [f32::INFINITY; 3]);
    }
}

#[test]
fn a_vector_is_a_single_query() {
    let folder = tempfile::tempdir().unwrap();
    let two = array(&queries(1), DIM);
    let text = String::from_utf8_lossy(&two[10..128]).replace("(1, 340)", "(340,)");
    let mut bytes = two[..10].to_vec();
    bytes.extend(format!("{:<118}", text.trim_end()).bytes());
    bytes.extend(&two[128..]);
    fs::write(folder.path().join("v.npy"), bytes).unwrap();
    done(&mut search(folder.path(), &["v.npy", "--out", "i.npy", "--k", "3"]));
    assert_eq!(ids(&fs::read(folder.path().join("i.npy")).unwrap())[0].len(), 3);
}

#[test]
fn records_tell_the_time_and_the_neighbours() {
    let folder = folder(&queries(9));
    let outcome = done(&mut search(folder.path(), &["q.npy", "--json", "--rounds", "3", "--timings"]));
    let summary = &outcome.json_lines()[0];
    assert_eq!((&summary["queries"], &summary["k"], &summary["dim"]), (&9.into(), &10.into(), &DIM.into()));
    assert_eq!(summary["rounds"].as_array().unwrap().len(), 3);
    for key in ["ns_per_query", "open_ns", "threads", "candidates", "share_of_database"] {
        assert!(summary[key].as_f64().unwrap() > 0.0, "{key} in {summary}");
    }
    assert_eq!(summary["exact"], false);
    assert!(summary["effort"]["probes"].as_f64().unwrap() >= 1.0, "{summary}");
    assert!((0.5..=1.0).contains(&summary["predicted_recall"].as_f64().unwrap()), "{summary}");
    assert!(outcome.stderr.contains("9 queries, 10 neighbours each"), "{}", outcome.stderr);

    let outcome = done(&mut search(folder.path(), &["q.npy", "--neighbours", "--k", "2", "--exact"]));
    let records = outcome.json_lines();
    assert_eq!(records.len(), 9);
    assert_eq!(records[8]["query"], 8);
    let nearest = &records[8]["neighbours"][0];
    assert!(nearest["distance"].as_f64() <= records[8]["neighbours"][1]["distance"].as_f64());
    assert!(nearest["file"].as_str().unwrap().contains(nearest["grasp"].as_str().unwrap()), "{nearest}");

    let text = done(&mut search(folder.path(), &["q.npy", "--k", "1"]));
    assert_eq!(text.stdout.lines().filter(|line| line.starts_with("query ")).count(), 3);
    assert!(text.stderr.contains("and 6 more"), "{}", text.stderr);
}

#[test]
fn more_effort_finds_no_less() {
    let folder = folder(&queries(40));
    let candidates = |arguments: &[&str]| {
        let outcome = done(&mut search(folder.path(), &[&["q.npy", "--json"], arguments].concat()));
        outcome.json_lines()[0]["share_of_database"].as_f64().unwrap()
    };
    let (one, four) = (candidates(&["--probes", "1"]), candidates(&["--probes", "4"]));
    assert!(one < four && one < 1.0, "{one} {four}");
    assert_eq!(candidates(&["--exact"]), 1.0);
    assert!(candidates(&["--recall", "0.5"]) <= candidates(&["--recall", "1"]));
    assert!(candidates(&["--eps", "0.2"]) <= candidates(&["--eps", "0", "--success", "1"]));
}

/// The error of a search for `bytes`.
fn refusal(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("q.npy"), bytes).unwrap();
    let outcome = run(&mut search(folder.path(), &["q.npy", "--out", "i.npy"]));
    assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{}", outcome.stderr);
    let left: Vec<PathBuf> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(left.len(), 1, "{left:?}");
    outcome.stderr.trim_end().to_owned()
}

#[test]
fn arrays_that_cannot_be_searched_for_are_told() {
    let sound = array(&queries(2), DIM);
    let header = |from: &str, to: &str| {
        let text = String::from_utf8_lossy(&sound[10..128]).replace(from, to);
        [&sound[..10], format!("{:<118}", text.trim_end()).as_bytes(), &sound[128..]].concat()
    };
    insta::assert_snapshot!(refusal(&header("<f4", "<f8")), @"grasp-query: cannot use the queries q.npy: its values are '<f8', <f4 is needed: convert them with astype('<f4')");
    insta::assert_snapshot!(refusal(&header("False", "True")), @"grasp-query: cannot use the queries q.npy: its values lie column by column (Fortran order): save numpy.ascontiguousarray(...) of it");
    insta::assert_snapshot!(refusal(&header("(2, 340)", "(2, 170, 2)")), @"grasp-query: cannot use the queries q.npy: its shape is (2, 170, 2): (rows, columns) is needed, or (columns,) for a single row");
    insta::assert_snapshot!(refusal(&header("(2, 340)", "(2, 170)")), @"grasp-query: cannot use the queries q.npy: its rows have 170 values, 340 are needed");
    insta::assert_snapshot!(refusal(&header("(2, 340)", "(0, 340)")), @"grasp-query: q.npy holds no query");
    insta::assert_snapshot!(refusal(&header("(2, 340)", "(4294967296, 340)")), @"grasp-query: cannot use the queries q.npy: truncated: 5841155522560 bytes of values expected, 2720 found: copy or write the file again");
    insta::assert_snapshot!(refusal(&sound[..sound.len() - 1]), @"grasp-query: cannot use the queries q.npy: truncated: 2720 bytes of values expected, 2719 found: copy or write the file again");
    insta::assert_snapshot!(refusal(b""), @"grasp-query: cannot use the queries q.npy: not a .npy file (it ends too soon): write one with numpy.save");
    insta::assert_snapshot!(refusal(b"0.1 0.2 0.3\n"), @"grasp-query: cannot use the queries q.npy: not a .npy file (it begins otherwise): write one with numpy.save");
    let mut values = queries(5);
    values[3 * DIM + 2] = f32::NAN;
    insta::assert_snapshot!(refusal(&array(&values, DIM)), @"grasp-query: cannot use the queries q.npy: row 3 (counted from 0) holds NaN in column 2: leave such rows out");
}

#[test]
fn options_that_cannot_be_are_told() {
    let folder = folder(&queries(1));
    let told = |arguments: &[&str], expected: &str| {
        let outcome = run(&mut search(folder.path(), &[&["q.npy"], arguments].concat()));
        assert_eq!(outcome.status, 2, "{arguments:?}");
        assert!(outcome.stderr.contains(expected), "{arguments:?}: {}", outcome.stderr);
    };
    for share in ["0", "1.01", "-0.5", "NaN", "most"] {
        told(&["--recall", share], "a number above 0 and at most 1");
        told(&["--eps", "0.05", "--success", share], "a number above 0 and at most 1");
    }
    told(&["--eps", "-0.1"], "a number of 0 or more");
    told(&["--success", "0.9"], "--eps");
    told(&["--recall", "0.9", "--eps", "0.05"], "cannot be used with");
    told(&["--exact", "--probes", "3"], "cannot be used with");
    told(&["--probes", "0"], "--probes");
    told(&["--k", "0"], "from 1 to 100000");
    told(&["--out", "q.npy"], "is an input as well");
    told(&["--out", "a.npy", "--distances", "a.npy"], "the same file");
    told(&["--out", "-", "--json"], "standard output");
    told(&["--out", "missing/a.npy"], "no folder");
    let sound = fs::read(folder.path().join("q.npy")).unwrap();
    assert!(sound == array(&queries(1), DIM), "the queries were overwritten");
    let none = run_with_input(&mut search(folder.path(), &["-"]), &[]);
    assert!(none.status == 2 && none.stderr.contains("ends too soon"), "{}", none.stderr);
}
