//! The whole chain over the real programs: what a newcomer does in the first five minutes.

use std::path::Path;

use grasp_tests::{pictures, program, run, run_with_input, small_index};

fn recognise(arguments: &[&str]) -> grasp_tests::Outcome {
    run(program("grasp-query")
        .args(["recognise", "--json", "--accept", "always", "--index"])
        .arg(small_index())
        .args(arguments))
}

fn sample(name: &str) -> String {
    pictures().join(name).display().to_string()
}

#[test]
fn an_index_answers_for_its_own_render() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let rendered = run(program("grasp-builder").args(["render", "--step", "30", "--out"]).arg(&set));
    assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    finds_its_own(&set, small_index(), 1e-3, 1e-6);
}

#[test]
fn hands_described_upright_are_found_at_any_roll() {
    let folder = tempfile::tempdir().unwrap();
    let (level, rolled, index) =
        (folder.path().join("level"), folder.path().join("rolled"), folder.path().join("upright.idx"));
    for (set, rolls) in [(&level, &[][..]), (&rolled, &["--rolls", "5"])] {
        let rendered =
            run(program("grasp-builder").args(["render", "--step", "45"]).args(rolls).arg("--out").arg(set));
        assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    }
    let built = run(program("grasp-builder")
        .args(["build", "--descriptor", "upright", "--out"])
        .arg(&index)
        .arg(&level));
    assert_eq!(built.status, 0, "{}", built.stderr);
    finds_its_own(&level, &index, 1e-3, 1e-6);
    // Its own view is the nearest whatever the roll, and its orientation is turned back: to some
    // degrees, where a small hand's pixels fall otherwise.
    finds_its_own(&rolled, &index, 0.5, 0.01);
}

/// Recognises some pictures of a set of the views in `index`: the nearest is the picture's own, at
/// most `far` away, and `1 - |p . q|` of the orientations' quaternions is at most `apart`, for all
/// where both are strict, and for nine in ten where they are not.
fn finds_its_own(set: &Path, index: &Path, far: f64, apart: f64) {
    let mut manifest = csv::Reader::from_path(set.join("manifest.csv")).unwrap();
    let headers = manifest.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let rows: Vec<csv::StringRecord> = manifest.records().map(Result::unwrap).collect();
    assert_eq!(rows.len() % 6, 0);
    let (mut asked, mut missed) = (0, Vec::new());
    for row in rows.iter().step_by(rows.len() / 12 - 1) {
        let picture = set.join(&row[column("file")]);
        let options =
            ["recognise", "--json", "--accept", "always", "--segmented", "--hand", "right", "--k", "1"];
        let answer = &run(program("grasp-query").args(options).arg("--index").arg(index).arg(&picture))
            .json_lines()[0];
        // A quaternion and its negative are the same rotation.
        let product: f64 = ["qx", "qy", "qz", "qw"]
            .iter()
            .enumerate()
            .map(|(at, name)| {
                let labelled: f64 = row[column(name)].parse().unwrap();
                labelled * answer["neighbours"][0]["quaternion_xyzw"][at].as_f64().unwrap()
            })
            .sum();
        asked += 1;
        let is_found = answer["grasp"] == row[column("grasp")]
            && answer["neighbours"][0]["distance"].as_f64().unwrap() < far
            && product.abs() > 1.0 - apart;
        if !is_found {
            missed.push(format!("{}: {answer}", picture.display()));
        }
    }
    let may_miss = if far < 0.01 { 0 } else { asked / 10 };
    assert!(missed.len() <= may_miss, "{} of {asked}: {missed:#?}", missed.len());
}

#[test]
fn every_sample_picture_with_a_hand_gets_an_answer() {
    let mut labels = csv::Reader::from_path(pictures().join("labels.csv")).unwrap();
    let mut seen = 0;
    for row in labels.records().map(Result::unwrap) {
        let picture = sample(&row[0]);
        let outcome = if &row[2] == "segmented" {
            recognise(&["--segmented", &picture])
        } else {
            recognise(&[&picture])
        };
        assert_eq!(outcome.status, 0, "{picture}: {}{}", outcome.stdout, outcome.stderr);
        let answer = &outcome.json_lines()[0];
        let probabilities: Vec<f64> = answer["classes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|class| class["probability"].as_f64().unwrap())
            .collect();
        assert_eq!(probabilities.len(), 6);
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-6);
        assert!(probabilities.is_sorted_by(|a, b| a >= b));
        assert!(answer["error"].is_null());
        seen += 1;
    }
    assert!(seen >= 12, "only {seen} sample pictures");
}

#[test]
fn a_picture_and_its_mirror_image_show_the_same_grasp_by_the_other_hand() {
    let folder = tempfile::tempdir().unwrap();
    let mirrored = folder.path().join("mirrored.png");
    let picture = first_segmented();
    image::open(&picture).unwrap().fliph().save(&mirrored).unwrap();
    let right = &recognise(&["--segmented", "--hand", "right", &picture]).json_lines()[0];
    let left = &recognise(&["--segmented", "--hand", "left", mirrored.to_str().unwrap()]).json_lines()[0];
    assert_eq!(right["grasp"], left["grasp"]);
    assert_eq!(right["neighbours"][0]["file"], left["neighbours"][0]["file"]);
    assert_eq!((&right["hand"], &left["hand"]), (&"right".into(), &"left".into()));
}

#[test]
fn pictures_come_by_pipe_as_well() {
    let picture = first_segmented();
    let by_name = &recognise(&["--segmented", &picture]).json_lines()[0];
    let piped = run_with_input(
        program("grasp-query")
            .args(["recognise", "--json", "--accept", "always", "--segmented", "-", "--index"])
            .arg(small_index()),
        &std::fs::read(&picture).unwrap(),
    );
    assert_eq!(piped.status, 0, "{}", piped.stderr);
    assert_eq!(by_name["neighbours"], piped.json_lines()[0]["neighbours"]);
}

#[test]
fn a_stream_of_frames_gets_a_record_each() {
    let frame = image::open(first_segmented()).unwrap().to_rgb8();
    let mut one = Vec::new();
    image::DynamicImage::from(frame)
        .write_to(&mut std::io::Cursor::new(&mut one), image::ImageFormat::Pnm)
        .unwrap();
    let piped = run_with_input(
        program("grasp-query")
            .args(["recognise", "--json", "--accept", "always", "--segmented", "-", "--index"])
            .arg(small_index()),
        &one.repeat(3),
    );
    assert_eq!(piped.status, 0, "{}", piped.stderr);
    let answers = piped.json_lines();
    assert_eq!(answers.len(), 3);
    assert!(answers.iter().all(|answer| answer["grasp"] == answers[0]["grasp"]));
}

#[test]
fn evaluate_scores_the_sample_pictures() {
    let outcome = run(program("grasp-query")
        .args(["evaluate", "--json"])
        .arg(pictures().join("labels.csv"))
        .arg("--index")
        .arg(small_index()));
    assert!(outcome.status <= 1, "{}", outcome.stderr);
    let report = &outcome.json_lines()[0];
    for key in [
        "n",
        "top1",
        "per_class",
        "per_stage",
        "confusion",
        "orientation_error_deg",
        "unknown",
        "ms_per_picture",
    ] {
        assert!(!report[key].is_null(), "{key} is missing from {report}");
    }
}

fn first_segmented() -> String {
    let mut labels = csv::Reader::from_path(pictures().join("labels.csv")).unwrap();
    let row = labels.records().map(Result::unwrap).find(|row| &row[2] == "segmented").unwrap();
    sample(&row[0])
}
