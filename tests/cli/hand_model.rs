//! A hand from a file is rendered, indexed and found like our own; a file that is no hand is
//! refused by name.

use std::fs;
use std::path::{Path, PathBuf};

use grasp_tests::{Outcome, boxes, program, run};
use serde_json::json;

fn folder_with_boxes() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("boxes.glb");
    fs::write(&model, boxes::hand()).unwrap();
    (folder, model)
}

fn builder(arguments: &[&str], model: &Path, out: &Path) -> Outcome {
    run(program("grasp-builder").args(arguments).arg("--hand-model").arg(model).arg("--out").arg(out))
}

#[test]
fn a_hand_from_a_file_is_rendered_indexed_and_found() {
    let (folder, model) = folder_with_boxes();
    let set = folder.path().join("set");
    let rendered = builder(&["render", "--hands", "0", "--step", "60"], &model, &set);
    assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    let mut manifest = csv::Reader::from_path(set.join("manifest.csv")).unwrap();
    let shape = manifest.headers().unwrap().iter().position(|name| name == "hand_shape").unwrap();
    let rows: Vec<_> = manifest.records().map(Result::unwrap).collect();
    assert!(rows.len() > 30 && rows.iter().all(|row| &row[shape] == "boxes"), "{rows:?}");

    let index = folder.path().join("both.idx");
    let built = builder(&["build", "--step", "60"], &model, &index);
    assert_eq!(built.status, 0, "{}", built.stderr);
    let inspected = run(program("grasp-builder").args(["inspect", "--json"]).arg(&index));
    assert_eq!(inspected.json_lines()[0]["hand_shapes"], json!(["mean", "boxes"]), "{}", inspected.stdout);

    let picture = &rows[rows.len() / 2][0];
    let answer = run(program("grasp-query")
        .args(["recognise", "--json", "--segmented", "--hand", "right", "--index"])
        .arg(&index)
        .arg(set.join(picture)));
    let nearest = &answer.json_lines()[0]["neighbours"][0];
    assert_eq!(nearest["file"], *picture, "{}", answer.stdout);
    assert_eq!(nearest["hand_shape"], "boxes", "{}", answer.stdout);
}

#[test]
fn thread_counts_give_the_same_bytes() {
    let (folder, model) = folder_with_boxes();
    let indexes = ["1", "2"].map(|threads| {
        let index = folder.path().join(threads);
        let built = builder(
            &["build", "--preset", "wide", "--hands", "1", "--step", "90", "--threads", threads],
            &model,
            &index,
        );
        assert_eq!(built.status, 0, "{}", built.stderr);
        fs::read(index).unwrap()
    });
    assert!(indexes[0] == indexes[1], "indexes built by 1 and by 2 threads differ");
}

#[test]
fn what_is_no_hand_is_refused_by_name() {
    let (folder, model) = folder_with_boxes();
    let out = folder.path().join("grasp.idx");
    let refused = |arguments: &[&str], model: &Path| {
        let outcome = builder(arguments, model, &out);
        assert_eq!(outcome.status, 2, "{}", outcome.stderr);
        assert!(!out.exists());
        outcome.stderr.replace(&folder.path().display().to_string(), "DIR")
    };
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let bytes = fs::read(&model).unwrap();
    let cut = write("cut.glb", &bytes[..bytes.len() / 2]);
    let picture = write("picture.glb", b"\x89PNG");
    let spaces = write("my hand.glb", &bytes);
    let missing = folder.path().join("missing.glb");
    insta::assert_snapshot!(refused(&["build"], &cut), @"grasp-builder: cannot use the hand of DIR/cut.glb: it is damaged: truncated: 9016 bytes expected, 4508 found");
    insta::assert_snapshot!(refused(&["build"], &picture), @"grasp-builder: cannot use the hand of DIR/picture.glb: it is not a binary glTF file: export the hand as .glb");
    insta::assert_snapshot!(refused(&["build"], &spaces), @"grasp-builder: cannot use the hand of DIR/my hand.glb: a hand cannot be named `my hand`: rename the file, using up to 64 of a-z, A-Z, 0-9, - and _, and not the name of a built-in hand");
    insta::assert_snapshot!(refused(&["render"], &missing), @"grasp-builder: cannot use the hand of DIR/missing.glb: it cannot be read: No such file or directory (os error 2)");
    insta::assert_snapshot!(refused(&["build", "--hand-model", model.to_str().unwrap()], &model), @"grasp-builder: two files of --hand-model are named boxes: rename one");
    insta::assert_snapshot!(refused(&["queries"], &model), @"grasp-builder: queries are of hands that no index holds: leave out --hand-model");
    let none = run(program("grasp-builder").args(["build", "--hands", "0", "--out"]).arg(&out));
    assert_eq!(none.status, 2);
    insta::assert_snapshot!(none.stderr, @"grasp-builder: --hands 0 leaves no hand to render: add --hand-model FILE.glb");
}
