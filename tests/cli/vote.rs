//! What answers are worth: calibrated probabilities, hands that are unknown, orientations and their spread.

use std::fs;
use std::path::PathBuf;

use grasp_tests::{Outcome, pictures, program, run, small_index};
use serde_json::Value;

fn sample() -> PathBuf {
    pictures().join("segmented/10-power-sphere.png")
}

fn recognise(arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["recognise", "--segmented", "--hand", "right"])
        .arg(sample())
        .arg("--index")
        .arg(small_index())
        .args(arguments))
}

fn inspect(index: &std::path::Path) -> Value {
    run(program("grasp-builder").args(["inspect", "--json"]).arg(index)).json_lines().remove(0)
}

#[test]
fn a_build_calibrates_by_hands_that_it_does_not_hold() {
    let vote = &inspect(small_index())["vote"];
    let measured = &vote["measured"];
    assert!(measured["queries"].as_u64().unwrap() > 300, "{vote}");
    assert!(measured["ece"].as_f64().unwrap() < 0.15, "{vote}");
    assert!(measured["log_likelihood"].as_f64().unwrap() > -1.79, "better than chance: {vote}");
    assert!(vote["farthest"].as_f64().unwrap() > 0.0, "{vote}");

    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--json", "--hand", "right", "--accept", "always", "--index"])
        .arg(small_index())
        .arg(pictures().join("labels.csv")));
    let report = &evaluated.json_lines()[0];
    let bins = report["calibration"]["reliability"].as_array().unwrap();
    let answers: u64 = bins.iter().map(|bin| bin["n"].as_u64().unwrap()).sum();
    assert_eq!(report["calibration"]["n"].as_u64().unwrap(), answers);
    let apart = |bin: &Value| {
        let [n, stated, right] = ["n", "probability", "right"].map(|key| bin[key].as_f64().unwrap());
        n * (stated - right).abs()
    };
    let ece: f64 = bins.iter().map(apart).sum::<f64>() / answers as f64;
    assert!((report["calibration"]["ece"].as_f64().unwrap() - ece).abs() < 1e-9, "{report}");
    let spread = report["spread"]["bins"].as_array().unwrap();
    let turned: u64 = spread.iter().map(|bin| bin["error_deg"]["n"].as_u64().unwrap()).sum();
    assert_eq!(report["orientation_error_deg"]["n"].as_u64().unwrap(), turned);
}

#[test]
fn vectors_without_held_out_ones_are_not_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let builder = |arguments: &[&str]| {
        let done = run(program("grasp-builder").args(arguments).current_dir(folder.path()));
        assert_eq!(done.status, 0, "{}", done.stderr);
    };
    let index = small_index().to_str().unwrap();
    builder(&["export", index, "--descriptors", "x.npy", "--labels", "y.csv"]);
    builder(&["build", "--descriptors", "x.npy", "--labels", "y.csv", "--out", "own.idx"]);
    let vote = &inspect(&folder.path().join("own.idx"))["vote"];
    assert!(vote["measured"].is_null() && vote["farthest"].is_null(), "{vote}");
    assert_eq!((vote["k"].as_u64(), vote["power"].as_f64()), (Some(10), Some(1.0)));
}

#[test]
fn a_hand_that_the_index_has_nothing_like_is_unknown() {
    let known = recognise(&["--json", "--accept", "always"]);
    assert_eq!(known.status, 0, "{}", known.stderr);
    let known = &known.json_lines()[0];
    assert!(known["reason"].is_null() && known["cutkosky"].is_u64(), "{known}");

    let unknown = recognise(&["--json", "--unknown-at", "0.001"]);
    assert_eq!(unknown.status, 1, "{}", unknown.stderr);
    let unknown = &unknown.json_lines()[0];
    assert_eq!(unknown["grasp"], "unknown");
    assert!(unknown["cutkosky"].is_null() && unknown["error"].is_null(), "{unknown}");
    assert!(unknown["reason"].as_str().unwrap().contains("known hands lie within 0.001"), "{unknown}");
    for key in ["classes", "orientation", "neighbours", "probability"] {
        assert_eq!(unknown[key], known[key], "{key}");
    }
    let sum: f64 =
        unknown["classes"].as_array().unwrap().iter().map(|c| c["probability"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9);

    let text = recognise(&["--unknown-at", "0.001"]);
    assert!(
        text.stdout.contains(": unknown · right hand") && text.stdout.contains("    or "),
        "{}",
        text.stdout
    );
    let both = recognise(&["--unknown-at", "1", "--accept", "always"]);
    assert!(both.status == 2 && both.stderr.contains("cannot be used with"), "{}", both.stderr);

    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--json", "--unknown-at", "0.001", "--index"])
        .arg(small_index())
        .arg(pictures().join("labels.csv")));
    let report = &evaluated.json_lines()[0];
    assert_eq!((report["unknown"].as_u64(), report["top1"].as_f64()), (report["n"].as_u64(), Some(0.0)));
}

#[test]
fn known_hands_are_told_from_things() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = String::from("file,kind,grasp\n");
    for n in 0..4u32 {
        let name = format!("bar-{n}.png");
        let is_bar = |x: u32, y: u32| (20..236).contains(&x) && (80..100 + 8 * n).contains(&y);
        let bar = image::GrayImage::from_fn(256, 192, |x, y| {
            image::Luma([if is_bar(x, y) { 120 + (x / 8 % 2 * 60) as u8 } else { 0 }])
        });
        bar.save(folder.path().join(&name)).unwrap();
        table.push_str(&format!("{name},segmented,pinch\n"));
    }
    fs::write(folder.path().join("things.csv"), table).unwrap();
    let told = run(program("grasp-query")
        .args(["experiment", "unknown", "--json", "--hand", "right", "--where", "kind=segmented"])
        .args(["--others", "things.csv", "--out", "results"])
        .arg(pictures().join("labels.csv"))
        .arg("--index")
        .arg(small_index())
        .current_dir(folder.path()));
    assert_eq!(told.status, 0, "{}", told.stderr);
    let figures = &told.json_lines()[0];
    assert_eq!((figures["known"].as_u64(), figures["others"].as_u64()), (Some(6), Some(4)), "{figures}");
    assert_eq!(figures["curves"][0]["measure"], "nearest");
    assert!(figures["curves"][0]["area"].as_f64().unwrap() > 0.9, "{figures}");
    let results = folder.path().join("results");
    let written: Value = serde_json::from_slice(&fs::read(results.join("unknown.json")).unwrap()).unwrap();
    assert_eq!(&written, figures);
    let rows = csv::Reader::from_path(results.join("unknown.csv")).unwrap().records().count();
    let points = |curve: &Value| curve["points"].as_array().unwrap().len();
    assert_eq!(rows, figures["curves"].as_array().unwrap().iter().map(points).sum::<usize>());
    assert!(fs::read_to_string(results.join("unknown.svg")).unwrap().starts_with("<svg"));
}
