//! `grasp-query simulate`, `experiment robustness` and `experiment imitation`: trials in the
//! physics engine, told and kept.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use grasp_tests::{Outcome, pictures, program, run, small_index, workspace};
use serde_json::Value;

fn simulate(folder: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-query").arg("simulate").args(arguments).current_dir(folder))
}

#[test]
fn a_trial_says_whether_the_object_was_lifted() {
    let folder = tempfile::tempdir().unwrap();
    let held = simulate(folder.path(), &["--grasp", "large-diameter"]);
    assert_eq!(held.status, 0, "{}", held.stderr);
    assert!(held.stdout.starts_with("wrap of barrett on cylinder-upright: holds"), "{}", held.stdout);
    let json = simulate(folder.path(), &["--grasp", "large-diameter", "--json"]).json_lines();
    let record = &json[0];
    assert_eq!((&record["success"], &record["lifted"]), (&Value::Bool(true), &Value::Bool(true)));
    let rise = record["rise_mm"].as_f64().unwrap();
    assert!(rise > 100.0 && held.stdout.contains(&format!("rose {rise:.0} mm")), "{}", held.stdout);

    let missed = simulate(folder.path(), &["--grasp", "pinch", "--y", "150", "--quality", "--json"]);
    let record = &missed.json_lines()[0];
    assert_eq!(
        (missed.status, &record["grasp"], &record["object"]),
        (1, &"two-finger-thumb".into(), &"block".into())
    );
    assert_eq!((&record["success"], &record["lifted"]), (&Value::Bool(false), &Value::Bool(false)));
    assert!(record["error"]["y"] == 0.15 && record["quality"].is_null(), "{record}");
    assert!(simulate(folder.path(), &["--grasp", "pinch", "--y", "150"]).stdout.contains(": not lifted"));
}

#[test]
fn a_strip_of_frames_shows_the_trial() {
    let folder = tempfile::tempdir().unwrap();
    let film = |name: &str| {
        let outcome = simulate(folder.path(), &["--grasp", "precision-disc", "--pictures", name, "--json"]);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        (outcome.stdout, fs::read(folder.path().join(name)).unwrap())
    };
    let first = film("a.png");
    assert_eq!(film("b.png"), first, "a trial repeats to the bit, and so do its pictures");
    let strip = image::load_from_memory(&first.1).unwrap().to_rgb8();
    assert_eq!(strip.dimensions(), (1500, 326));
    // A caption below each frame, and none in it.
    for frame in 0..5 {
        let band =
            |x: u32, y: u32| strip.get_pixel(300 * frame + x, 300 + y).0.iter().all(|value| *value < 90);
        let ink = (0..26).flat_map(|y| (0..300).map(move |x| (x, y))).filter(|(x, y)| band(*x, *y)).count();
        assert!(ink > 50, "{ink} dark pixels below frame {frame}");
    }
    // Under the lifted disc the table is darker than beside it: of its colour, but not of its
    // light.
    let shadow = |frame: u32| {
        let is_shade = |[r, g, b]: [u8; 3]| (110..150).contains(&r) && r > g && g > b && r - b < 25;
        let pixels = (0..300).flat_map(|y| (0..300).map(move |x| (300 * frame + x, y)));
        pixels.filter(|(x, y)| is_shade(strip.get_pixel(*x, *y).0)).count()
    };
    assert!(shadow(4) > 500, "{} pixels of shadow", shadow(4));
    // The disc is the only thing that is orange: it lies, and is up in the last frame.
    let middle_of_disc = |frame: u32| {
        let orange = |x: u32, y: u32| {
            let [r, g, b] = strip.get_pixel(x, y).0.map(i32::from);
            r > 2 * b && r > g + 30
        };
        let pixels = (0..300).flat_map(|y| (0..300).map(move |x| (300 * frame + x, y)));
        let rows: Vec<u32> = pixels.filter(|(x, y)| orange(*x, *y)).map(|(_, y)| y).collect();
        assert!(rows.len() > 50, "frame {frame} shows no disc");
        rows.iter().sum::<u32>() / rows.len() as u32
    };
    assert!(middle_of_disc(4) + 50 < middle_of_disc(0), "{} {}", middle_of_disc(4), middle_of_disc(0));
}

#[test]
fn ones_own_object_and_hand_are_tried() {
    let folder = tempfile::tempdir().unwrap();
    let hand = fs::read_to_string(workspace().join("query/data/robots/barrett.toml")).unwrap();
    let object = "name = 'can'\nshape = 'cylinder'\nradius = 0.033\nheight = 0.115\nmass = 0.3\nposition = [0, 0, 0.0575]\nquaternion_xyzw = [0, 0, 0, 1]\ntable = 0.0\n";
    let files = [
        ("own.toml", hand.replace("name = \"barrett\"", "name = \"own\"")),
        ("can.toml", object.to_owned()),
        ("sunk.toml", object.replace("0.0575", "0.03")),
        ("floating.toml", object.replace("table = 0.0", "")),
    ];
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let can = ["--grasp", "wrap", "--object", "can.toml", "--from", "side", "--robot", "own.toml"];
    let outcome = simulate(folder.path(), &can);
    assert_eq!(outcome.status, 0, "{}{}", outcome.stdout, outcome.stderr);
    assert!(outcome.stdout.starts_with("wrap of own on can: holds"), "{}", outcome.stdout);

    let mut said = String::new();
    for wrong in [
        ["--object", "sunk.toml", "--grasp", "wrap"],
        ["--object", "floating.toml", "--grasp", "wrap"],
        ["--object", "cup", "--grasp", "wrap"],
        ["--robot", "parallel-gripper", "--grasp", "pinch"],
        ["--robot", "shadow", "--grasp", "wrap"],
        ["--object", "can.toml", "--grasp", "hook"],
    ] {
        let outcome = simulate(folder.path(), &wrong);
        assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{wrong:?}");
        said += &outcome.stderr;
    }
    insta::assert_snapshot!(said);
}

/// Nine positions and three yaws of one object, of which one is both: eleven trials.
fn sweep(folder: &Path, out: &str, threads: &str) -> Command {
    let mut command = program("grasp-query");
    command
        .args(["experiment", "robustness", "--object", "block", "--reach", "10", "--step", "10"])
        .args(["--yaw", "15", "--yaw-step", "15", "--out", out, "--threads", threads])
        .current_dir(folder);
    command
}

#[test]
fn a_sweep_is_gone_on_with_where_it_was_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let first = run(sweep(folder.path(), "whole", "1").arg("--json"));
    assert_eq!(first.status, 0, "{}", first.stderr);
    let windows = &first.json_lines()[0]["tolerances"][0];
    assert_eq!((&windows["cells"], &windows["successes"]), (&9.into(), &9.into()));
    assert_eq!((&windows["position_mm"], &windows["yaw_deg"]), (&10.into(), &15.into()));
    let table = read("whole/robustness.csv");
    assert_eq!(table.lines().count(), 1 + 11);
    let map = read("whole/robustness.svg");
    assert!(map.starts_with("<svg") && map.matches("#0072B2").count() >= 12 && !map.contains("NaN"));

    // Killed in its midst: what was measured is there, and the rest is added to the same bytes.
    let mut stopped =
        sweep(folder.path(), "parts", "1").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    let lines = || {
        fs::read_to_string(folder.path().join("parts/robustness.csv")).map_or(0, |text| text.lines().count())
    };
    while lines() < 4 && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    stopped.kill().unwrap();
    stopped.wait().unwrap();
    let kept = read("parts/robustness.csv");
    assert!((4..12).contains(&kept.lines().count()), "{kept}");
    // A figure that no trial gives tells what was kept from what was measured anew.
    let mark = |text: &str| text.replacen(",true,true,", ",true,true,1", 1);
    fs::write(folder.path().join("parts/robustness.csv"), mark(&kept)).unwrap();
    let ended = run(&mut sweep(folder.path(), "parts", "1"));
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    assert_eq!(differing(&read("parts/robustness.csv"), &table), 1, "all but the mark");

    // The same, cut in the middle of a line, by two threads: not a byte differs.
    fs::write(folder.path().join("parts/robustness.csv"), &table[..table.len() / 2]).unwrap();
    let again = run(&mut sweep(folder.path(), "parts", "2"));
    assert_eq!(again.status, 0, "{}", again.stderr);
    for name in ["robustness.csv", "windows.csv", "robustness.svg"] {
        assert_eq!(read(&format!("parts/{name}")), read(&format!("whole/{name}")), "{name}");
    }

    // Whole, it is only read.
    fs::write(folder.path().join("whole/robustness.csv"), mark(&table)).unwrap();
    assert_eq!(run(&mut sweep(folder.path(), "whole", "1")).status, 0);
    assert_eq!(read("whole/robustness.csv"), mark(&table));

    let hand = fs::read_to_string(workspace().join("query/data/robots/barrett.toml")).unwrap();
    fs::write(folder.path().join("own.toml"), hand.replace("0.072", "0.070")).unwrap();
    let other = run(sweep(folder.path(), "whole", "1").args(["--robot", "own.toml"]));
    assert!(other.status == 2 && other.stderr.contains("made with another hand"), "{}", other.stderr);
}

/// How many lines differ.
fn differing(a: &str, b: &str) -> usize {
    assert_eq!(a.lines().count(), b.lines().count());
    a.lines().zip(b.lines()).filter(|(a, b)| a != b).count()
}

/// Labels of our own renders, one of each grasp, with the orientation turned by `change`.
fn labels(folder: &Path, change: impl Fn([f64; 4]) -> [f64; 4]) {
    let set = folder.join("set");
    let rendered = run(program("grasp-builder").args(["render", "--step", "30", "--out"]).arg(&set));
    assert_eq!(rendered.status, 0, "{}", rendered.stderr);
    let mut manifest = csv::Reader::from_path(set.join("manifest.csv")).unwrap();
    let headers = manifest.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = manifest.records().map(Result::unwrap).collect();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let each = rows.len() / 6;
    let mut table = String::from("file,kind,grasp,stage,hand,qx,qy,qz,qw\n");
    for row in rows.iter().skip(each / 3).step_by(each) {
        let [x, y, z, w] = change(["qx", "qy", "qz", "qw"].map(|name| row[column(name)].parse().unwrap()));
        let (file, grasp) = (&row[column("file")], &row[column("grasp")]);
        table += &format!("set/{file},segmented,{grasp},grasp,right,{x},{y},{z},{w}\n");
    }
    fs::write(folder.join("labels.csv"), table).unwrap();
}

fn imitation(folder: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["experiment", "imitation", "labels.csv", "--hand", "right", "--json", "--index"])
        .arg(small_index())
        .args(arguments)
        .current_dir(folder))
}

#[test]
fn what_is_recognised_exactly_is_lifted() {
    let folder = tempfile::tempdir().unwrap();
    labels(folder.path(), |quaternion| quaternion);
    // The nearest entry of the index is the render itself.
    let outcome = imitation(folder.path(), &["--k", "1", "--accept", "always"]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let report = &outcome.json_lines()[0];
    let classes = report["classes"].as_array().unwrap();
    assert_eq!(classes.len(), 7);
    for class in classes {
        let n = class["n"].as_u64().unwrap();
        assert_eq!(n, if class["grasp"] == "all" { 6 } else { 1 });
        for count in ["recognised", "robot_grasp_right", "success", "success_with_true_orientation"] {
            assert_eq!(class[count], n, "{count} of {class}");
        }
        assert!(class["orientation_error_deg"].as_f64().unwrap() < 0.1, "{class}");
    }
    assert_eq!(report["left_out"], 0);

    // Half a turn off about the hand's length: what is taken from above is reached for from below.
    labels(folder.path(), |[x, y, z, w]| [w, z, -y, -x]);
    let outcome = imitation(folder.path(), &["--k", "1", "--accept", "always"]);
    let all = &outcome.json_lines()[0]["classes"][6];
    assert_eq!((&all["grasp"], &all["success_with_true_orientation"]), (&"all".into(), &6.into()));
    assert!((all["orientation_error_deg"].as_f64().unwrap() - 180.0).abs() < 0.1, "{all}");
    let success = all["success"].as_u64().unwrap();
    assert!((1..6).contains(&success), "{all}");
    assert!((all["share"].as_f64().unwrap() - success as f64 / 6.0).abs() < 1e-9);
}

#[test]
fn what_is_unknown_is_not_imitated_and_what_has_no_orientation_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| pictures().join("segmented").join(name).display().to_string();
    let table = format!(
        "file,kind,grasp,stage,hand,qx,qy,qz,qw\n{},segmented,pinch,grasp,right,0,0,0,1\n{},segmented,power-sphere,grasp,right,,,,\n",
        picture("09-pinch.png"),
        picture("10-power-sphere.png")
    );
    fs::write(folder.path().join("labels.csv"), table).unwrap();
    let outcome = imitation(folder.path(), &["--unknown-at", "0.001"]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let report = &outcome.json_lines()[0];
    let all = &report["classes"][1];
    assert_eq!((&all["n"], &all["recognised"], &all["success"]), (&1.into(), &0.into(), &0.into()));
    assert_eq!(report["left_out"], 1);

    fs::write(folder.path().join("labels.csv"), "file,kind,grasp\nmissing.png,segmented,pinch\n").unwrap();
    let missing = imitation(folder.path(), &[]);
    assert_eq!(missing.status, 2);
    let shadow = imitation(folder.path(), &["--robot", "shadow"]);
    assert!(
        shadow.status == 2 && shadow.stderr.contains("there is no robot hand `shadow`"),
        "{}",
        shadow.stderr
    );
}
