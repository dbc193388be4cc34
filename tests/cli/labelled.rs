//! `grasp-query experiment`: the paper's experiments over labelled pictures.

use std::fs;
use std::path::Path;

use grasp_tests::{Outcome, pictures, program, run, small_index};

fn paper(arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["experiment", "paper"])
        .arg(pictures().join("labels.csv"))
        .arg("--index")
        .arg(small_index())
        .args(arguments))
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
}

#[test]
fn the_papers_sets_are_scored_like_evaluate_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/results");
    let outcome = paper(&["--json", "--hand", "right", "--out", out.to_str().unwrap()]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let figures = &outcome.json_lines()[0];
    let file: serde_json::Value = serde_json::from_slice(&fs::read(out.join("paper.json")).unwrap()).unwrap();
    assert_eq!(&file, figures);

    let kinds = figures["kinds"].as_array().unwrap();
    assert_eq!(kinds.iter().map(|kind| &kind["kind"]).collect::<Vec<_>>(), ["segmented", "camera"]);
    for kind in kinds {
        let name = kind["kind"].as_str().unwrap();
        let condition = format!("kind={name}");
        for (set, conditions) in [
            (&kind["sets"][0], vec!["--where", &condition]),
            (&kind["sets"][2], vec!["--where", &condition, "--where", "stage=grasp"]),
        ] {
            let evaluated = run(program("grasp-query")
                .args(["evaluate", "--json", "--hand", "right", "--index"])
                .arg(small_index())
                .arg(pictures().join("labels.csv"))
                .args(conditions));
            let report = &evaluated.json_lines()[0];
            for key in ["n", "top1", "unknown", "confusion", "orientation_error_deg", "euler_error_deg"] {
                assert_eq!(set[key], report[key], "{key} of {name}");
            }
            let errors = set["orientation_errors_deg"].as_array().unwrap();
            assert_eq!(errors.len() as u64, set["orientation_error_deg"]["n"].as_u64().unwrap());
            assert!(errors.is_sorted_by(|a, b| a.as_f64() <= b.as_f64()));
        }
        assert_eq!(kind["sets"][0]["paper"]["top1"]["n"], 36);
    }
    assert_eq!(rows(&out.join("paper.csv")).len(), 6);
    // A row for each class, of an answer for each class and for none.
    assert_eq!(rows(&out.join("confusion.csv")).len(), 6 * 6 * 7);
    let last = rows(&out.join("orientation.csv")).pop().unwrap();
    assert_eq!(&last[3], "1.0", "the last step of a distribution is all of it: {last:?}");
    for drawing in ["confusion.svg", "orientation.svg"] {
        let text = fs::read_to_string(out.join(drawing)).unwrap();
        assert!(text.starts_with("<svg") && text.contains("paper") && !text.contains("NaN"), "{drawing}");
    }
}

#[test]
fn the_papers_figures_stand_beside_ones_own() {
    let outcome = paper(&["--where", "kind=segmented", "--hand", "right"]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let lines: Vec<&str> = outcome.stdout.lines().collect();
    assert_eq!(lines.iter().filter(|line| line.contains("    the paper  ")).count(), 3, "{}", outcome.stdout);
    assert!(outcome.stdout.contains("0.0°, 16.8°, 10.5°") && outcome.stdout.contains("61 %"));
    assert!(!outcome.stdout.contains("camera pictures"), "{}", outcome.stdout);
}

#[test]
fn a_picture_that_cannot_be_used_is_named_and_fails_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels.csv");
    let picture = pictures().join("segmented/09-pinch.png");
    fs::write(
        &labels,
        format!("file,kind,grasp\n{},segmented,pinch\nmissing.png,camera,pinch\n", picture.display()),
    )
    .unwrap();
    let outcome = run(program("grasp-query")
        .args(["experiment", "paper"])
        .arg(&labels)
        .arg("--index")
        .arg(small_index()));
    assert_eq!(outcome.status, 2);
    assert!(outcome.stdout.contains("line 3: missing.png"), "{}", outcome.stdout);

    // Where the first picture is missing, the others say where they lie; lines are counted alike on
    // every system; what is in none of the classes is not missing an answer.
    let no_hand = pictures().join("camera/no-hand.jpg");
    let table = format!(
        "file,kind,grasp\nmissing.png,segmented,pinch\ncopy/a.png,segmented,pinch\n{},camera,other\nb.png,film,pinch\n",
        no_hand.display()
    );
    fs::create_dir_all(folder.path().join("table/below")).unwrap();
    fs::create_dir(folder.path().join("copy")).unwrap();
    fs::copy(pictures().join("segmented/09-pinch.png"), folder.path().join("copy/a.png")).unwrap();
    for line_end in ["\n", "\r\n"] {
        let labels = folder.path().join("table/below/labels.csv");
        fs::write(&labels, table.replace('\n', line_end)).unwrap();
        let outcome = run(program("grasp-query")
            .args(["evaluate", "--json", "--index"])
            .arg(small_index())
            .arg(&labels));
        let report = &outcome.json_lines()[0];
        assert_eq!(
            (&report["n"], &report["unknown"], &report["other"]["n"]),
            (&1.into(), &0.into(), &1.into())
        );
        let lines: Vec<_> = report["errors"]
            .as_array()
            .unwrap()
            .iter()
            .map(|error| error["line"].as_u64().unwrap())
            .collect();
        assert_eq!(lines, [5, 2], "{report}");
    }
    let nothing = paper(&["--where", "kind=film"]);
    assert!(nothing.status == 2 && nothing.stderr.contains("no row of"), "{}", nothing.stderr);
}

#[test]
fn shapes_are_built_once_and_scored_like_evaluate() {
    let folder = tempfile::tempdir().unwrap();
    let build = |counts: &str| {
        run(program("grasp-builder")
            .args(["experiment", "shapes", "--step", "30", "--out", "shapes", "--counts", counts])
            .current_dir(folder.path()))
    };
    let first = build("3,1");
    assert_eq!(first.status, 0, "{}", first.stderr);
    let index = |count: u32| format!("shapes/hands-{count:04}.idx");
    assert_eq!(
        first.stdout.trim(),
        format!(
            "grasp-query experiment shapes LABELS.csv --out shapes --index {} --index {}",
            index(1),
            index(3)
        )
    );
    let bytes = fs::read(folder.path().join(index(3))).unwrap();
    let second = build("1,2,3");
    assert_eq!(second.stderr.matches("is up to date").count(), 2, "{}", second.stderr);
    assert_eq!(fs::read(folder.path().join(index(3))).unwrap(), bytes);

    // The largest first: the number is read from the index, not from the order.
    let labels = pictures().join("labels.csv");
    let scored = run(program("grasp-query")
        .args(["experiment", "shapes", "--json", "--hand", "right", "--out", "results"])
        .args(["--index", &index(3), "--index", &index(1)])
        .arg(&labels)
        .current_dir(folder.path()));
    assert_eq!(scored.status, 0, "{}", scored.stderr);
    let figures = &scored.json_lines()[0];
    let points = figures["points"].as_array().unwrap();
    let shapes: Vec<u64> = points.iter().map(|point| point["hand_shapes"].as_u64().unwrap()).collect();
    assert_eq!(shapes, [1, 3, 1, 3], "grasp stage, segmented and camera: {figures}");
    for point in points {
        let evaluated = run(program("grasp-query")
            .args(["evaluate", "--json", "--hand", "right", "--where", "stage=grasp", "--where"])
            .arg(format!("kind={}", point["kind"].as_str().unwrap()))
            .args(["--index", point["index"].as_str().unwrap()])
            .arg(&labels)
            .current_dir(folder.path()));
        let report = &evaluated.json_lines()[0];
        assert_eq!((&point["n"], &point["top1"]), (&report["n"], &report["top1"]));
        assert_eq!(point["orientation_median_deg"], report["orientation_error_deg"]["median"]);
    }
    let results = folder.path().join("results");
    assert_eq!(rows(&results.join("shapes.csv")).len(), points.len());
    let drawing = fs::read_to_string(results.join("shapes.svg")).unwrap();
    assert_eq!(drawing.matches("<circle").count(), 2 * 2 * points.len());

    let none = run(program("grasp-query").args(["experiment", "shapes"]).arg(&labels));
    assert!(none.status == 2 && none.stderr.contains("--index"), "{}", none.stderr);
}

#[test]
fn changed_pictures_are_scored_beside_pictures_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    let labels = pictures().join("labels.csv");
    let chosen = ["--json", "--hand", "right", "--where", "kind=segmented"];
    let outcome = run(program("grasp-query")
        .args(["experiment", "steadiness", "--out", out.to_str().unwrap(), "--index"])
        .arg(small_index())
        .arg(&labels)
        .args(chosen));
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let figures = &outcome.json_lines()[0];
    let file = fs::read(out.join("steadiness.json")).unwrap();
    assert_eq!(&serde_json::from_slice::<serde_json::Value>(&file).unwrap(), figures);

    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--index"])
        .arg(small_index())
        .arg(&labels)
        .args(chosen));
    let report = &evaluated.json_lines()[0];
    let changes = figures["changes"].as_array().unwrap();
    let [first, rest @ ..] = changes.as_slice() else { panic!("{figures}") };
    assert_eq!(first["change"], "as it is");
    assert_eq!((&first["right"]["top1"], &first["same"]), (&report["top1"], &1.0.into()));
    assert_eq!(first["orientation_error_deg"], report["orientation_error_deg"]["median"]);
    let n = report["n"].as_u64().unwrap();
    for change in rest {
        assert_eq!((&change["right"]["n"], &change["hand_right"]), (&n.into(), &serde_json::Value::Null));
        // Hands of these renders are not so near to another grasp, nor labels turned the wrong way.
        assert!(change["same"].as_f64().unwrap() >= 0.5, "{change}");
        assert!(change["orientation_error_deg"].as_f64().unwrap() < 40.0, "{change}");
    }
    let counts = ["always", "sometimes", "never"].map(|count| figures[count].as_u64().unwrap());
    assert_eq!(counts.iter().sum::<u64>(), n);

    let rows = rows(&out.join("steadiness.csv"));
    assert_eq!(rows.len() as u64, n * changes.len() as u64);
    let mirrored = rows.iter().find(|row| &row[1] == "mirrored").unwrap();
    assert_eq!((&mirrored[5], &mirrored[6]), ("left", "left"), "{mirrored:?}");
}

#[test]
fn a_thorough_look_is_one_at_camera_pictures_in_several_variants() {
    let look = |file: &str, arguments: &[&str]| {
        let outcome = run(program("grasp-query")
            .args(["recognise", "--json", "--index"])
            .arg(small_index())
            .args(arguments)
            .arg(pictures().join(file)));
        assert!(outcome.status < 2, "{}", outcome.stderr);
        let record = outcome.json_lines()[0].clone();
        ["classes", "orientation", "hand", "neighbours", "warnings"].map(|key| record[key].clone())
    };
    let camera = "camera/10-power-sphere.jpg";
    let [quick, thorough] = [&["--thorough"][..0], &["--thorough"]].map(|option| look(camera, option));
    assert_ne!(quick[0], thorough[0], "other variants say the same to the last digit");
    assert_eq!(quick[0][0]["grasp"], thorough[0][0]["grasp"]);
    assert_eq!(thorough, look(camera, &["--thorough"]));
    // The neighbours to look at are those of the picture as it is.
    assert_eq!((&quick[2], &quick[3]), (&thorough[2], &thorough[3]));
    assert_eq!(quick[4], thorough[4]);
    // Equation 4 as printed is the neighbours' alone.
    let printed =
        [&["--euler-mean"][..], &["--euler-mean", "--thorough"]].map(|options| look(camera, options));
    assert_eq!(printed[0][1], printed[1][1]);
    assert_ne!(printed[0][0], printed[1][0]);
    let cut_out = "segmented/09-pinch.png";
    let [quick, thorough] =
        [&["--segmented"][..], &["--segmented", "--thorough"]].map(|options| look(cut_out, options));
    assert_eq!(quick[..4], thorough[..4]);
    let kinds = |record: &serde_json::Value| {
        record.as_array().unwrap().iter().map(|warning| warning["kind"].clone()).collect::<Vec<_>>()
    };
    assert!(!kinds(&quick[4]).contains(&"looked_at_once".into()));
    assert!(kinds(&thorough[4]).contains(&"looked_at_once".into()));
}

#[test]
fn predictions_are_a_table_of_what_was_answered() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("answers.csv");
    let outcome = run(program("grasp-query")
        .args(["evaluate", "--json", "--hand", "right", "--where", "kind=segmented", "--index"])
        .arg(small_index())
        .arg(pictures().join("labels.csv"))
        .arg("--predictions")
        .arg(&out));
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);

    let mut table = csv::Reader::from_path(&out).unwrap();
    let columns: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    let column = |name: &str| columns.iter().position(|column| column == name).unwrap();
    for name in &columns {
        assert_eq!(columns.iter().filter(|other| *other == name).count(), 1, "{name} is there twice");
    }
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let report = &outcome.json_lines()[0];
    assert_eq!(rows.len() as u64, report["n"].as_u64().unwrap());
    let right = rows.iter().filter(|row| row[column("labelled")] == row[column("grasp")]).count();
    let share = right as f64 / rows.len() as f64;
    assert!((share - report["top1"].as_f64().unwrap()).abs() < 1e-9);
    for row in &rows {
        assert!(row[column("distance")].parse::<f64>().unwrap() > 0.0, "{row:?}");
        assert!((0.0..=1.0).contains(&row[column("probability")].parse().unwrap()), "{row:?}");
    }
}

#[test]
fn a_picture_that_is_labelled_twice_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels.csv");
    let picture = pictures().join("segmented/09-pinch.png");
    let evaluate = |grasps: &[&str]| {
        let rows = grasps.iter().map(|grasp| format!("{},segmented,{grasp}\n", picture.display()));
        fs::write(&labels, format!("file,kind,grasp\n{}", rows.collect::<String>())).unwrap();
        let arguments = ["evaluate", "--json", "--index"];
        run(program("grasp-query").args(arguments).arg(small_index()).arg(&labels))
    };
    let warning = |outcome: &Outcome| {
        outcome.stderr.matches("that a row before does, first line 3 that of line 2").count()
    };
    let once = evaluate(&["pinch"]);
    assert_eq!((once.status, warning(&once)), (0, 0), "{}", once.stderr);

    let same = evaluate(&["pinch", "pinch", "pinch"]);
    assert_eq!((same.status, warning(&same)), (0, 1), "{}", same.stderr);
    assert!(same.stderr.contains("2 rows label"), "{}", same.stderr);
    assert_eq!(same.json_lines()[0]["n"], 3);

    // One of two labels is wrong: which, nobody can know but the user.
    let contradicting = evaluate(&["pinch", "lateral"]);
    assert_eq!((contradicting.status, warning(&contradicting)), (2, 0), "{}", contradicting.stderr);
    let report = &contradicting.json_lines()[0];
    assert_eq!((&report["n"], &report["errors"][0]["line"]), (&1.into(), &3.into()), "{report}");
}
