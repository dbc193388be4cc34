//! `grasp-query experiment report`: one page of somebody's own pictures.

use std::fs;
use std::path::Path;

use grasp_tests::{Outcome, pictures, program, run, small_index};

fn report(labels: &Path, out: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["experiment", "report"])
        .arg(labels)
        .arg("--out")
        .arg(out)
        .arg("--index")
        .arg(small_index())
        .args(arguments))
}

/// What stands between two texts, wherever they occur.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Vec<&'a str> {
    text.split(before).skip(1).filter_map(|rest| rest.split(after).next()).collect()
}

#[test]
fn one_page_says_what_evaluate_says() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report.html");
    let labels = pictures().join("labels.csv");
    let outcome = report(&labels, &out, &["--json", "--hand", "right"]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let figures = &outcome.json_lines()[0];
    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--json", "--hand", "right", "--index"])
        .arg(small_index())
        .arg(&labels));
    let expected = &evaluated.json_lines()[0];
    for (key, value) in expected.as_object().unwrap() {
        if key != "ms_per_picture" {
            assert_eq!(&figures[key], value, "{key}");
        }
    }

    // Intervals hold their shares, and every group of evaluate has its row.
    let accuracy = figures["accuracy"].as_array().unwrap();
    assert_eq!(accuracy[0]["by"], "all");
    assert_eq!((&accuracy[0]["n"], &accuracy[0]["top1"]), (&expected["n"], &expected["top1"]));
    for row in accuracy {
        let [low, high] = [0, 1].map(|end| row["interval"][end].as_f64().unwrap());
        let share = row["top1"].as_f64().unwrap();
        assert!(low <= share && share <= high && high - low > 0.1, "few pictures say little: {row}");
    }
    let grouped = ["per_class", "per_stage", "per_kind", "per_group", "per_hand"];
    let groups: usize = grouped.iter().map(|key| expected[key].as_object().map_or(0, |map| map.len())).sum();
    assert_eq!(accuracy.len(), 1 + groups);
    let speed = &figures["speed"];
    let [p50, p99, most] = ["p50_ms", "p99_ms", "most_ms"].map(|key| speed[key].as_f64().unwrap());
    assert!(0.0 < p50 && p50 <= p99 && p99 <= most, "{speed}");

    // Every picture is on one shelf, and shown there as a small picture.
    let page = fs::read_to_string(&out).unwrap();
    let mut shown = Vec::new();
    for shelf in ["right", "wrong", "doubtful"] {
        let shelf = &figures["shown"][shelf];
        let pictures = shelf["pictures"].as_array().unwrap();
        assert_eq!(shelf["n"].as_u64().unwrap().min(8), pictures.len() as u64);
        shown.extend(pictures.iter().map(|picture| picture["file"].as_str().unwrap()));
    }
    let sources = between(&page, "<img src=\"", "\"");
    assert_eq!(sources.len(), shown.len());
    assert!(sources.iter().all(|source| source.starts_with("data:image/jpeg;base64,/9j/")));
    for file in shown {
        assert!(page.contains(&format!("alt=\"{file}\"")), "{file}");
    }
    let right = figures["shown"]["right"]["pictures"].as_array().unwrap();
    assert!(right.iter().all(|picture| picture["grasp"] == picture["labelled"]));
    let stated = |picture: &serde_json::Value| picture["probability"].as_f64();
    assert!(right.is_sorted_by(|one, other| stated(one) >= stated(other)));

    // All of it is in the page: nothing is fetched, nothing runs.
    for outside in ["<script", "http:", "https:", "<link", "@import", "url(", "<iframe"] {
        let found = page.replace("http://www.w3.org/2000/svg", "").contains(outside);
        assert!(!found, "{outside}");
    }
    let percent = format!("<strong>{:.1} %</strong>", 100.0 * expected["top1"].as_f64().unwrap());
    assert!(page.contains(&percent) && page.contains("<svg width=\"1080\""), "{percent}");
    let cells = between(&page, "<td class=\"right\"", "</td>").len();
    assert_eq!(cells, expected["confusion"]["classes"].as_array().unwrap().len());
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
}

#[test]
fn pictures_that_cannot_be_used_are_named_and_names_cannot_command_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let name = "<script>alert(1)&\".png";
    fs::copy(pictures().join("segmented/09-pinch.png"), folder.path().join(name)).unwrap();
    fs::write(folder.path().join("none.png"), "no picture").unwrap();
    let labels = folder.path().join("labels.csv");
    let quoted = name.replace('"', "\"\"");
    fs::write(
        &labels,
        format!("file,kind,grasp,group\n\"{quoted}\",segmented,pinch,<b>\nnone.png,camera,pinch,x\nnone.png,camera,fist,x\n"),
    )
    .unwrap();
    let out = folder.path().join("report.html");
    let outcome = report(&labels, &out, &["--show", "1"]);
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(
        outcome.stdout.contains("line 3: none.png: ") && outcome.stdout.contains("line 4: the table: `fist`"),
        "{}",
        outcome.stdout
    );
    let page = fs::read_to_string(&out).unwrap();
    assert!(!page.contains("<script") && !page.contains("<b>&") && !page.contains("><b></th>"), "escaped");
    assert!(page.contains("&#60;script&#62;alert(1)&#38;&#34;.png"), "{page}");
    assert!(page.contains("<td>3</td><td>none.png</td>") && page.contains("<td>4</td><td>the table</td>"));
    assert_eq!(page.matches("<img ").count(), 1);
}

#[test]
fn an_input_is_not_written_over_and_nothing_is_left_of_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels.csv");
    fs::copy(pictures().join("segmented/09-pinch.png"), folder.path().join("a.png")).unwrap();
    fs::write(&labels, "file,kind,grasp\na.png,segmented,pinch\n").unwrap();
    for input in ["labels.csv", "a.png"] {
        let outcome = report(&labels, &folder.path().join(input), &[]);
        assert!(outcome.status == 2 && outcome.stderr.contains("is an input as well"), "{}", outcome.stderr);
    }
    let nowhere = report(&labels, &folder.path().join("none/report.html"), &[]);
    assert_eq!(nowhere.status, 2, "{}", nowhere.stderr);
    let mut left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["a.png", "labels.csv"]);
}
