//! Vectors in and out: `build --descriptors`, `export`, `queries`.

use std::fs;
use std::path::Path;
use std::process::Command;

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_index::{Effort, Index, SearchOptions, VoteOptions};
use grasp_tests::{Outcome, pictures, program, run, small_index};

fn builder(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program("grasp-builder");
    command.args(arguments).current_dir(folder);
    command
}

fn done(command: &mut Command) -> Outcome {
    let outcome = run(command);
    assert_eq!(outcome.status, 0, "{command:?}: {}", outcome.stderr);
    outcome
}

/// What a command that cannot succeed says, without the name of the program.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let outcome = run(&mut builder(folder, arguments));
    assert_eq!(outcome.status, 2, "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
    let parts: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(!parts.iter().any(|name| name.to_string_lossy().ends_with(".part")), "{parts:?}");
    outcome.stderr.trim_end().trim_start_matches("grasp-builder: ").to_owned()
}

fn array(values: &[f32], columns: usize) -> Vec<u8> {
    let rows = (values.len() / columns) as u64;
    let mut bytes = NpyHeader { element: NpyType::F32, rows, columns: columns as u64, offset: 0 }.to_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Rows of 3 values.
fn some(rows: usize) -> Vec<f32> {
    (0..rows * 3).map(|at| ((at * 37) % 101) as f32 / 10.0).collect()
}

fn exported() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let index = small_index().display().to_string();
    done(&mut builder(folder.path(), &["export", &index, "--descriptors", "x.npy", "--labels", "y.csv"]));
    folder
}

#[test]
fn what_is_exported_and_built_again_gives_the_same_answers() {
    let folder = exported();
    let build = ["build", "--descriptors", "x.npy", "--labels", "y.csv", "--out", "again.idx"];
    done(&mut builder(folder.path(), &[&build[..], &["--descriptor", "default"]].concat()));
    let again_path = folder.path().join("again.idx");
    let (index, again) = (Index::open(small_index()).unwrap(), Index::open(&again_path).unwrap());
    assert!(again.verify().is_sound());
    assert_eq!(again.len(), index.len());
    for id in 0..index.len() as u32 {
        let (one, other) = (index.entry(id).unwrap(), again.entry(id).unwrap());
        let apart = one.orientation.unwrap().angle_to(&other.orientation.unwrap());
        assert!(apart < 1e-4, "entry {id}: {apart}");
        assert_eq!((one.class, one.file, one.hand_shape), (other.class, other.file, other.hand_shape));
        assert_eq!((one.stage, one.object, one.view_deg), (other.stage, other.object, other.view_deg));
        assert_eq!(index.descriptor(id), again.descriptor(id));
    }
    for effort in [Effort::Recall(0.95), Effort::Probes(2), Effort::Exact] {
        for id in (0..index.len() as u32).step_by(7) {
            let mut query = index.descriptor(id).unwrap().into_owned();
            query.iter_mut().enumerate().for_each(|(at, value)| *value += 0.01 * (at % 5) as f32);
            let options = SearchOptions { k: 10, effort };
            let [one, other] =
                [&index, &again].map(|index| index.search(&query, &options).unwrap().neighbours);
            assert_eq!(one, other);
            // With held-out hands of its own each is calibrated otherwise.
            let plain = VoteOptions { sigma_scale: Some(1.0), ..VoteOptions::default() };
            let vote = |index: &Index| index.vote(&one, &plain);
            assert_eq!(vote(&index).classes, vote(&again).classes);
        }
    }
    // Pictures too.
    let picture = pictures().join("segmented/09-pinch.png").display().to_string();
    let answer = |index: &Path| {
        let mut command = program("grasp-query");
        command.args(["recognise", "--json", "--segmented", &picture, "--k", "10", "--sigma-scale", "1"]);
        command.args(["--accept", "always", "--index"]).arg(index);
        done(&mut command).json_lines().remove(0)
    };
    let (one, other) = (answer(small_index()), answer(&again_path));
    assert_eq!((&one["grasp"], &one["probability"]), (&other["grasp"], &other["probability"]));

    // And once more: the same bytes, as nothing has changed.
    let before = fs::read(&again_path).unwrap();
    let same = done(&mut builder(folder.path(), &[&build[..], &["--descriptor", "default"]].concat()));
    assert!(same.stdout.contains("is up to date"), "{}", same.stdout);
    assert_eq!(fs::read(&again_path).unwrap(), before);
    fs::remove_file(&again_path).unwrap();
    let one_thread = [&build[..], &["--descriptor", "default", "--threads", "1"]].concat();
    done(&mut builder(folder.path(), &one_thread));
    assert!(
        fs::read(&again_path).unwrap() == before,
        "the number of threads, or what was there, changes bytes"
    );
}

#[test]
fn vectors_alone_are_searched_but_recognise_nothing() {
    let folder = exported();
    done(&mut builder(folder.path(), &["build", "--descriptors", "x.npy", "--out", "raw.idx"]));
    let query = |arguments: &[&str]| {
        let mut command = program("grasp-query");
        command.args(arguments).args(["--index", "raw.idx"]).current_dir(folder.path());
        run(&mut command)
    };
    let searched = query(&["search", "x.npy", "--k", "1", "--out", "ids.npy"]);
    assert_eq!(searched.status, 0, "{}", searched.stderr);
    let bytes = fs::read(folder.path().join("ids.npy")).unwrap();
    let start = NpyHeader::read(&mut &bytes[..], NpyType::U32).unwrap().offset as usize;
    let ids: Vec<u32> =
        bytes[start..].chunks_exact(4).map(|id| u32::from_le_bytes(id.try_into().unwrap())).collect();
    let own = ids.iter().zip(0..).filter(|(id, at)| *id == at).count();
    // Some rows are alike.
    assert!(own * 10 > ids.len() * 9, "{own} of {}", ids.len());

    let picture = pictures().join("segmented/09-pinch.png").display().to_string();
    let answer = query(&["recognise", "--segmented", &picture]);
    assert_eq!(answer.status, 2);
    assert!(answer.stderr.contains("the index holds raw vectors"), "{}", answer.stderr);
    done(&mut builder(
        folder.path(),
        &["build", "--descriptors", "x.npy", "--descriptor", "default", "--out", "raw.idx"],
    ));
    let answer = query(&["recognise", "--segmented", &picture]);
    assert_eq!(answer.status, 2);
    assert!(answer.stderr.contains("without labels"), "{}", answer.stderr);
    assert!(refused(folder.path(), &["export", "raw.idx", "--labels", "y.csv"]).contains("has no labels"));
}

#[test]
fn arrays_that_are_none_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let sound = array(&some(4), 3);
    let mut infinite = some(4);
    infinite[7] = f32::INFINITY;
    let header = |text: &str| {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        bytes
    };
    let cases: [(Vec<u8>, &str); 9] = [
        (sound[..sound.len() - 1].to_vec(), "truncated: 48 bytes of values expected, 47 found"),
        (array(&infinite, 3), "row 2 (counted from 0) holds inf in column 1"),
        (b"P5 640 480".to_vec(), "not a .npy file"),
        (Vec::new(), "not a .npy file"),
        (array(&[], 3), "holds 0 rows of 3 values"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }"), "its values are"),
        (header("{'descr': '<f4', 'fortran_order': True, 'shape': (4, 3), }"), "Fortran order"),
        (header("{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, 2), }"), "its shape is (4, 3, 2)"),
        (
            header("{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551615, 3), }"),
            "truncated",
        ),
    ];
    for (bytes, says) in cases {
        fs::write(folder.path().join("x.npy"), bytes).unwrap();
        let said = refused(folder.path(), &["build", "--descriptors", "x.npy", "--out", "x.idx"]);
        assert!(said.contains(says) && said.contains("x.npy"), "{says}: {said}");
    }
    assert!(refused(folder.path(), &["build", "--descriptors", "none.npy"]).contains("cannot read none.npy"));
    assert!(refused(folder.path(), &["build", "--descriptors", "."]).contains("not a regular file"));
    fs::write(folder.path().join("x.npy"), &sound).unwrap();
    let said = refused(folder.path(), &["build", "--descriptors", "x.npy", "--out", "x.npy"]);
    assert!(said.contains("choose another --out"), "{said}");
    let said = refused(folder.path(), &["build", "--descriptors", "x.npy", "--descriptor", "default"]);
    assert!(
        said.contains("the rows have 3 values, and those of the descriptor `default` have 340"),
        "{said}"
    );
    fs::write(folder.path().join("q.npy"), array(&some(4), 2)).unwrap();
    let said = refused(folder.path(), &["build", "--descriptors", "x.npy", "--held-out", "q.npy"]);
    assert!(said.contains("has rows of 2 values, the index's have 3"), "{said}");
    assert_eq!(fs::read(folder.path().join("x.npy")).unwrap(), sound);
}

#[test]
fn tables_of_labels_that_are_none_are_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x.npy"), array(&some(2), 3)).unwrap();
    let cases = [
        ("file,class\na,b\nc,d\n", "no column `grasp`"),
        ("grasp\npinch\n", "y.csv has 1 lines and x.npy 2 rows"),
        ("grasp,stage\npinch,grasp\n,grasp\n", "line 3: no grasp"),
        ("grasp,qx,qy,qz\npinch,0,0,0\npinch,0,0,0\n", "qw is missing"),
        ("grasp,qx,qy,qz,qw\npinch,0,0,0,1\npinch,0,0,0,2\n", "line 3: qx, qy, qz, qw have length 2.0000"),
        ("grasp,azimuth,elevation\npinch,0,inf\npinch,0,0\n", "line 2: `inf` in column `elevation`"),
        ("grasp,azimuth,elevation\npinch,0,\npinch,0,0\n", "`` in column `elevation`"),
        ("grasp,hand\npinch,right\npinch,left\n", "flip left ones"),
        ("grasp,cutkosky\npinch,9\npinch,8\n", "grasp `pinch` is number 9 on a line before, and 8 here"),
        ("grasp,stage\npinch,grasp\npinch\n", "y.csv, line 3: not a line of this table"),
    ];
    for (text, says) in cases {
        fs::write(folder.path().join("y.csv"), text).unwrap();
        let said = refused(
            folder.path(),
            &["build", "--descriptors", "x.npy", "--labels", "y.csv", "--out", "x.idx"],
        );
        assert!(said.contains(says) && said.contains("y.csv"), "{says}: {said}");
    }
    fs::write(folder.path().join("y.csv"), "grasp,note\npinch,one\nwave,two\n").unwrap();
    done(&mut builder(
        folder.path(),
        &["build", "--descriptors", "x.npy", "--labels", "y.csv", "--out", "x.idx"],
    ));
    let index = Index::open(folder.path().join("x.idx")).unwrap();
    let classes: Vec<_> = index.catalogue().classes.iter().map(|c| (c.name.as_str(), c.cutkosky)).collect();
    assert_eq!(classes, [("wave", 0), ("pinch", 9)]);
    assert_eq!(index.catalogue().kept.names(), ["labels"]);
}

#[test]
fn queries_are_of_other_hands_and_always_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, more: &[&str]| {
        done(&mut builder(
            folder.path(),
            &[&["queries", "--descriptor", "default", "--count", "60", "--out", name], more].concat(),
        ));
        fs::read(folder.path().join(name)).unwrap()
    };
    let one = write("one.npy", &["--threads", "1"]);
    let header = NpyHeader::read(&mut &one[..], NpyType::F32).unwrap();
    assert_eq!((header.columns, header.rows > 50), (340, true));
    assert!(one == write("two.npy", &["--threads", "2"]), "the number of threads changes queries");
    let clean = write("clean.npy", &["--clean"]);
    assert!(one != clean && one != write("other.npy", &["--seed", "8"]));
    // None of them is in an index.
    let index = Index::open(small_index()).unwrap();
    let header = NpyHeader::read(&mut &clean[..], NpyType::F32).unwrap();
    let values = header.read_values(&mut &clean[header.offset as usize..]).unwrap();
    for query in values.chunks_exact(340) {
        let found = index.search(query, &SearchOptions { k: 1, effort: Effort::Exact }).unwrap();
        assert!(found.neighbours[0].distance > 1e-3);
    }
}

#[test]
fn an_index_says_which_hands_were_held_out() {
    let index = Index::open(small_index()).unwrap();
    let held_out = index.catalogue().provenance.iter().find(|(key, _)| key == "held out");
    assert_eq!(
        held_out.unwrap().1,
        "1200 views of hand-2000000, hand-2000001, hand-2000002, hand-2000003, hand-2000004, hand-2000005, seed 7, renderer 4"
    );
}

#[test]
fn nothing_is_exported_over_the_index() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(small_index(), folder.path().join("a.idx")).unwrap();
    let said = refused(folder.path(), &["export", "a.idx", "--labels", "./a.idx"]);
    assert!(said.contains("is the index itself"), "{said}");
    assert!(refused(folder.path(), &["export", "a.idx"]).contains("--descriptors"));
}

#[test]
fn an_index_that_tells_two_grasps_of_one_number_apart_can_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x.npy"), array(&some(40), 3)).unwrap();
    let row = |at: usize| format!("{},1,{}\n", ["bottle", "can"][at % 2], ["ann", "ben"][at / 20]);
    let labels: String = (0..40).map(row).collect();
    let labels = format!("grasp,cutkosky,hand_shape\n{labels}");
    fs::write(folder.path().join("y.csv"), &labels).unwrap();
    let build = ["build", "--descriptors", "x.npy", "--labels"];
    done(&mut builder(folder.path(), &[&build[..], &["y.csv", "--out", "own.idx"]].concat()));
    done(&mut builder(folder.path(), &["remove", "own.idx", "--hand-shape", "ben"]));
    let index = Index::open(folder.path().join("own.idx")).unwrap();
    assert_eq!((index.len(), index.catalogue().classes.len()), (20, 2));

    // Two names for one number in two indexes may be two names for one grasp.
    fs::write(folder.path().join("jar.csv"), labels.replace("can", "jar")).unwrap();
    done(&mut builder(folder.path(), &[&build[..], &["jar.csv", "--out", "jar.idx"]].concat()));
    let said = refused(folder.path(), &["compact", "own.idx", "jar.idx", "--out", "both.idx"]);
    assert_eq!(said, "can and jar have the same number: give each grasp its own");
}
