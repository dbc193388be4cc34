//! A network is trained, an index is built by it, and a picture is recognised.

use std::fs;

use grasp_tests::{boxes, pictures, program, run, small_index, workspace};

#[test]
fn a_trained_network_describes_an_index_that_recognises() {
    let folder = tempfile::tempdir().unwrap();
    let builder = |arguments: &[&str]| {
        let outcome = run(program("grasp-builder").args(arguments).current_dir(folder.path()));
        assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
        outcome
    };
    let trained = builder(&["train", "--out", "tiny.network", "--samples", "2000", "--no-progress"]);
    let (_, rest) = trained.stdout.split_once("tiny.network: network ").unwrap();
    let fingerprint = &rest[..16];
    assert!(rest.contains("2.0 MB, trained on 1,984 samples, seed 7\n"), "{}", trained.stdout);
    assert_eq!(trained.stderr, "");
    let mut written: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    written.sort();
    assert_eq!(written, ["tiny.network", "tiny.network.csv"]);
    let mut curve = csv::Reader::from_path(folder.path().join("tiny.network.csv")).unwrap();
    let headers = curve.headers().unwrap().clone();
    assert_eq!(headers.iter().take(3).collect::<Vec<_>>(), ["samples", "loss", "class_loss"]);
    let rows: Vec<csv::StringRecord> = curve.records().map(Result::unwrap).collect();
    assert_eq!(rows.iter().map(|row| &row[0]).collect::<Vec<_>>(), ["1984"]);

    builder(&[
        "build",
        "--hands",
        "1",
        "--views",
        "2",
        "--descriptor",
        "learned",
        "--network",
        "tiny.network",
        "--out",
        "tiny.idx",
    ]);
    let text = builder(&["inspect", "tiny.idx"]).stdout;
    assert!(
        text.contains(&format!("learned, D = 128: of hands turned upright, by the network {fingerprint}")),
        "{text}"
    );
    let json = builder(&["inspect", "tiny.idx", "--json"]).json_lines();
    assert_eq!(json[0]["descriptor"]["network"], fingerprint);

    let picture = pictures().join("segmented/09-pinch.png");
    let index = folder.path().join("tiny.idx");
    let answer = run(program("grasp-query")
        .args(["recognise", "--segmented", "--json"])
        .arg(picture)
        .arg("--index")
        .arg(index));
    // What so small a network makes of it is its own affair.
    assert!(answer.status <= 1, "{}", answer.stderr);
    assert_eq!(answer.json_lines()[0]["classes"].as_array().map(Vec::len), Some(6));
}

#[test]
fn a_descriptors_network_is_shown_no_scenes_to_leave_something_out_of() {
    let folder = tempfile::tempdir().unwrap();
    let train = ["train", "--out", "hand.network", "--samples", "64", "--without", "skin"];
    let outcome = run(program("grasp-builder").args(train).current_dir(folder.path()));
    assert_ne!(outcome.status, 0);
    assert!(
        outcome.stderr.contains("give --kind scene, naming, thing or mask as well"),
        "{}",
        outcome.stderr
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn networks_of_scenes_are_taken_from_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let recognise = |arguments: &[&str]| {
        run(program("grasp-query")
            .args(["recognise", "--json", "--accept", "always", "--index"])
            .arg(small_index())
            .arg(pictures().join("camera/09-pinch.jpg"))
            .args(arguments)
            .current_dir(folder.path()))
    };
    let empty = recognise(&["--networks", "."]);
    assert_eq!(empty.status, 2);
    assert!(
        empty.stderr.contains("holds none of scene.network, naming.network, thing.network, mask.network"),
        "{}",
        empty.stderr
    );
    // Another network of the same form names the hand.
    let things = workspace().join("query/recognise/data/thing.network");
    fs::copy(things, folder.path().join("naming.network")).unwrap();
    let [built_in, own] = [&[] as &[&str], &["--networks", "."]].map(|arguments| {
        let outcome = recognise(arguments);
        assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
        outcome.json_lines()[0]["classes"].clone()
    });
    assert_ne!(built_in, own);
    let skin = recognise(&["--networks", ".", "--segment", "skin"]);
    assert_eq!(skin.status, 2);
    assert!(skin.stderr.contains("which --segment skin leaves out"), "{}", skin.stderr);
}

#[test]
fn trained_networks_are_measured_on_the_same_renders() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("boxes.glb");
    fs::write(&model, boxes::hand()).unwrap();
    let measure = |kind: &str, networks: &[&str], arguments: &[&str]| {
        let networks = networks.iter().map(|network| workspace().join(network));
        run(program("grasp-builder")
            .args(["experiment", "networks", "--scenes", "6", "--kind", kind])
            .args(arguments)
            .args(networks))
    };
    let hand = "builder/data/hand.network";
    let twice = measure("hand", &[hand, hand], &["--json"]);
    assert_eq!(twice.status, 0, "{}", twice.stderr);
    let [first, second] = twice.json_lines().try_into().unwrap();
    assert_eq!(first, second);
    let top1 = |record: &serde_json::Value| record["figures"]["hands_top1"].as_f64().unwrap();
    // Of 72 renders the shipped network names some 55 rightly.
    assert!(top1(&first) > 0.6, "{first}");
    assert!(first["figures"]["hands_rotation_deg"].as_f64().unwrap() < 20.0, "{first}");

    // It has never seen a hand of boxes.
    let of_boxes = measure("hand", &[hand], &["--json", "--hand-model", model.to_str().unwrap()]);
    assert_eq!(of_boxes.status, 0, "{}", of_boxes.stderr);
    assert!(top1(&of_boxes.json_lines()[0]) < top1(&first), "{}", of_boxes.stdout);

    // A name that is no UTF-8 is shown as well as can be.
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt as _;
        let odd = folder.path().join(std::ffi::OsStr::from_bytes(b"\xff.network"));
        fs::copy(workspace().join(hand), &odd).unwrap();
        let odd = run(program("grasp-builder")
            .args(["experiment", "networks", "--scenes", "6", "--json"])
            .arg(&odd));
        assert_eq!(odd.status, 0, "{}", odd.stderr);
        assert_eq!(odd.json_lines()[0]["figures"], first["figures"]);
    }

    let text = measure("thing", &["query/recognise/data/thing.network"], &[]);
    assert_eq!(text.status, 0, "{}", text.stderr);
    assert!(text.stdout.contains("\n  objects mask iou "), "{}", text.stdout);

    let other = measure("naming", &[hand], &[]);
    assert_eq!(other.status, 2);
    assert!(other.stderr.contains("is of another kind: say which by --kind"), "{}", other.stderr);
}
