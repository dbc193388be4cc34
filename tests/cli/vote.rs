//! What answers are worth: calibrated probabilities, hands that are unknown, orientations and their
//! spread.

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
    // Nothing tempers what is stated where masks are given.
    let [probability, stated] = [&figures["curves"][1], &figures["curves"][3]];
    assert_eq!((&probability["measure"], &stated["measure"]), (&"probability".into(), &"stated".into()));
    assert_eq!((&probability["area"], &probability["points"]), (&stated["area"], &stated["points"]));
    let results = folder.path().join("results");
    let written: Value = serde_json::from_slice(&fs::read(results.join("unknown.json")).unwrap()).unwrap();
    assert_eq!(&written, figures);
    let rows = csv::Reader::from_path(results.join("unknown.csv")).unwrap().records().count();
    let points = |curve: &Value| curve["points"].as_array().unwrap().len();
    assert_eq!(rows, figures["curves"].as_array().unwrap().iter().map(points).sum::<usize>());
    assert!(fs::read_to_string(results.join("unknown.svg")).unwrap().starts_with("<svg"));
}

/// A wall of wooden planks in the colour of skin, which fills the frame. No hand is in it.
fn planks() -> image::RgbImage {
    image::RgbImage::from_fn(320, 240, |x, y| {
        let (row, along) = (y / 60, x + y / 60 * 97);
        if y % 60 < 5 || along % 160 < 4 {
            return image::Rgb([70, 50, 40]);
        }
        let grain = (f64::from(y) * 0.35 + 3.0 * (f64::from(x) * 0.01).sin()).sin();
        let light = 0.8 + 0.12 * f64::from((row * 7 + along / 160 * 3) % 4);
        let value = |mean: f64, swing: f64| (light * (mean + swing * grain)).clamp(0.0, 255.0) as u8;
        image::Rgb([value(205.0, 14.0), value(150.0, 12.0), value(118.0, 10.0)])
    })
}

fn kinds(record: &Value) -> Vec<&str> {
    let warnings = record["warnings"].as_array().unwrap();
    assert!(warnings.iter().all(|warning| warning["message"].as_str().is_some_and(|text| text.len() > 20)));
    warnings.iter().map(|warning| warning["kind"].as_str().unwrap()).collect()
}

#[test]
fn a_wooden_wall_of_the_colour_of_skin_is_warned_of_and_not_stated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("planks.png");
    planks().save(&path).unwrap();
    let recognise = |arguments: &[&str]| {
        run(program("grasp-query")
            .arg("recognise")
            .arg(&path)
            .arg("--index")
            .arg(small_index())
            .args(arguments))
    };
    // The scene network takes a plank for a hand, and does not name what it holds.
    let seen = recognise(&["--json", "--segment", "scene"]);
    let record = &seen.json_lines()[0];
    assert_eq!((record["grasp"].as_str(), seen.status), (Some("unknown"), 1), "{record}");
    assert!(record["probability"].as_f64().unwrap() < 0.25, "as good as a guess: {record}");
    assert!(!kinds(record).is_empty(), "{record}");
    let found = recognise(&["--json", "--segment", "skin"]);
    let record = &found.json_lines()[0];
    assert!(record["probability"].as_f64().unwrap() < 0.25, "as good as a guess: {record}");
    assert_eq!((record["grasp"].as_str(), found.status), (Some("unknown"), 1), "{record}");
    for kind in ["segmentation_doubtful", "mask_touches_border", "picture_unlike_calibration"] {
        assert!(kinds(record).contains(&kind), "{kind}: {record}");
    }
    let text = recognise(&["--segment", "skin"]).stdout;
    assert!(text.contains("    warning: ") && text.contains("the colour of skin"), "{text}");

    // Given for a segmented picture it is all hand, which no hand is.
    let record = &recognise(&["--json", "--segmented"]).json_lines()[0];
    assert_eq!(
        (record["grasp"].as_str(), kinds(record)[0]),
        (Some("unknown"), "mask_fills_frame"),
        "{record}"
    );
    let sum: f64 = record["classes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|class| class["probability"].as_f64().unwrap())
        .sum();
    assert!((sum - 1.0).abs() < 1e-9, "{record}");
}

#[test]
fn sample_pictures_that_are_classed_rightly_keep_their_answers() {
    let samples = |accept: &str| -> Vec<Value> {
        let mut command = program("grasp-query");
        // So few views are no sure ground to say which hand it is.
        command.args(["recognise", "--json", "--hand", "right", "--accept", accept, "--index"]);
        command.arg(small_index());
        for name in ["01-large-diameter", "02-small-diameter", "09-pinch", "12-precision-disc"] {
            command.arg(pictures().join(format!("camera/{name}.jpg")));
        }
        run(&mut command).json_lines()
    };
    let (calibrated, always) = (samples("calibrated"), samples("always"));
    assert_eq!((calibrated.len(), always.len()), (4, 4));
    for (named, always) in calibrated.iter().zip(always) {
        let file = named["file"].as_str().unwrap();
        assert!(file.contains(always["grasp"].as_str().unwrap()), "{always}");
        assert_eq!(named["grasp"], always["grasp"], "{named}");
        for kind in kinds(named) {
            assert!(
                !["segmentation_doubtful", "mask_fills_frame", "mask_touches_border"].contains(&kind),
                "{named}"
            );
        }
    }
}

#[test]
fn a_mask_that_was_given_is_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let [picture, mask] = ["planks.png", "mask.png"].map(|name| folder.path().join(name));
    planks().save(&picture).unwrap();
    let is_hand = |x: u32, y: u32| x.abs_diff(160).pow(2) + 2 * y.abs_diff(120).pow(2) < 80 * 80;
    image::GrayImage::from_fn(320, 240, |x, y| image::Luma([if is_hand(x, y) { 255 } else { 0 }]))
        .save(&mask)
        .unwrap();
    let given = run(program("grasp-query")
        .args(["recognise", "--json", "--accept", "always", "--index"])
        .arg(small_index())
        .arg("--mask")
        .arg(mask)
        .arg(picture));
    let record = &given.json_lines()[0];
    for kind in ["segmentation_doubtful", "mask_touches_border", "picture_unlike_calibration"] {
        assert!(!kinds(record).contains(&kind), "{kind}: {record}");
    }
    assert_ne!(record["grasp"], "unknown", "{record}");
}

#[test]
fn trust_is_fitted_to_the_same_bytes_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let fit = |threads: &str| {
        let out = folder.path().join(format!("trust-{threads}.toml"));
        let fitted = run(program("grasp-query")
            .args(["experiment", "trust", "--json", "--threads", threads])
            .arg(pictures().join("labels.csv"))
            .arg("--index")
            .arg(small_index())
            .arg("--out")
            .arg(&out));
        assert_eq!(fitted.status, 0, "{}", fitted.stderr);
        let model = fitted.json_lines().remove(0)["model"].clone();
        (model, fs::read_to_string(out).unwrap())
    };
    let (model, written) = fit("1");
    assert_eq!(model["hand_tried"]["measures"].as_object().unwrap().len(), 10, "{model}");
    assert!(written.contains("# Made by: grasp-query experiment trust pictures/labels.csv"), "{written}");
    assert_eq!(fit("2"), (model, written));
}

#[test]
fn open_hands_are_fitted_to_the_same_bytes_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let index = folder.path().join("learned.idx");
    let built = run(program("grasp-builder")
        .args(["build", "--descriptor", "learned", "--step", "60", "--out"])
        .arg(&index));
    assert_eq!(built.status, 0, "{}", built.stderr);
    let fit = |threads: &str| {
        let out = folder.path().join(format!("opening-{threads}.toml"));
        let fitted = run(program("grasp-query")
            .args(["experiment", "opening", "--json", "--threads", threads])
            .arg(pictures().join("labels.csv"))
            .arg("--index")
            .arg(&index)
            .arg("--out")
            .arg(&out));
        assert_eq!(fitted.status, 0, "{}", fitted.stderr);
        (fitted.json_lines().remove(0), fs::read_to_string(out).unwrap())
    };
    let (figures, written) = fit("1");
    assert_eq!(figures["log_odds"].as_object().unwrap().len(), 6, "{figures}");
    // All sample pictures hold their things: both parts are measured, and there is no other table.
    let by: Vec<&str> =
        figures["worth"].as_array().unwrap().iter().map(|row| row["by"].as_str().unwrap()).collect();
    assert_eq!(by, ["fitted", "held_out"], "{figures}");
    assert!(written.contains("# Made by: grasp-query experiment opening pictures/labels.csv"), "{written}");
    assert_eq!(fit("2"), (figures, written));
}

#[test]
fn open_hands_cannot_be_fitted_by_an_index_that_knows_no_stages() {
    let refused = run(program("grasp-query")
        .args(["experiment", "opening"])
        .arg(pictures().join("labels.csv"))
        .arg("--index")
        .arg(small_index()));
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("the index must know stages"), "{}", refused.stderr);
}

#[test]
fn an_evaluation_counts_what_is_stated_above_nine_tenths() {
    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--json", "--where", "kind=segmented", "--accept", "always", "--index"])
        .arg(small_index())
        .arg(pictures().join("labels.csv")));
    let stated = evaluated.json_lines().remove(0)["calibration"]["stated_above"].clone();
    let above: Vec<f64> =
        stated.as_array().unwrap().iter().map(|above| above["probability"].as_f64().unwrap()).collect();
    assert_eq!(above, [0.9, 0.8]);
    let count = |at: usize, key: &str| stated[at][key].as_u64().unwrap();
    assert!(count(0, "n") <= count(1, "n") && count(1, "right") <= count(1, "n"), "{stated}");
}
