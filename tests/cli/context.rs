//! What else is known of a hand than one picture: the frames before it (`--sequence`), the object
//! that it holds (`--prior`).

use std::path::PathBuf;

use grasp_tests::{Outcome, pictures, program, run, small_index};
use serde_json::Value;

fn recognise(names: &[&str], arguments: &[&str]) -> Outcome {
    let images: Vec<PathBuf> = names.iter().map(|name| pictures().join("segmented").join(name)).collect();
    run(program("grasp-query")
        .args(["recognise", "--segmented", "--hand", "right", "--accept", "always", "--json", "--index"])
        .arg(small_index())
        .args(images)
        .args(arguments))
}

fn probability(record: &Value, grasp: &str) -> f64 {
    let classes = record["classes"].as_array().unwrap();
    let class = classes.iter().find(|class| class["grasp"] == grasp).unwrap();
    class["probability"].as_f64().unwrap()
}

#[test]
fn frames_are_answered_by_all_frames_so_far() {
    let names = ["10-power-sphere.png", "10-power-sphere.png", "09-pinch.png", "10-power-sphere.png"];
    let alone = recognise(&names, &[]).json_lines();
    let together = recognise(&names, &["--sequence"]).json_lines();
    assert_eq!((alone.len(), together.len()), (4, 4));
    for (alone, together) in alone.iter().zip(&together) {
        assert!(alone.get("single").is_none());
        assert_eq!(together["single"]["grasp"], alone["grasp"]);
        assert_eq!(together["single"]["probability"], alone["probability"]);
        assert_eq!(together["single"]["quaternion_xyzw"], alone["orientation"]["quaternion_xyzw"]);
        let classes = together["classes"].as_array().unwrap();
        let sum: f64 = classes.iter().map(|class| class["probability"].as_f64().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }
    // The forward filter, once more: one frame in five changes the grasp, to any of six alike.
    let classes = alone[0]["classes"].as_array().unwrap();
    let grasps: Vec<&str> = classes.iter().map(|class| class["grasp"].as_str().unwrap()).collect();
    let mut believed = vec![1.0; 6];
    for (alone, together) in alone.iter().zip(&together) {
        let foreseen = believed.iter().map(|p| 0.8 * p + 0.2 / 6.0);
        let products: Vec<f64> =
            foreseen.zip(&grasps).map(|(p, grasp)| p * probability(alone, grasp)).collect();
        let sum: f64 = products.iter().sum();
        believed = products.into_iter().map(|product| product / sum).collect();
        for (grasp, expected) in grasps.iter().zip(&believed) {
            let found = probability(together, grasp);
            assert!((found - expected).abs() < 1e-9, "{grasp}: {found}, {expected} expected");
        }
    }
    assert!(
        together[1]["orientation"]["spread_deg"].as_f64() < together[0]["orientation"]["spread_deg"].as_f64()
    );

    let again = recognise(&names, &["--sequence", "--threads", "1"]).stdout;
    assert_eq!(
        recognise(&names, &["--sequence", "--threads", "2"]).stdout,
        again,
        "threads change a sequence"
    );
    // Where the grasp may be any other by the next frame, every frame stands alone.
    let free = recognise(&names, &["--sequence", "--switch", "1"]).json_lines();
    assert_eq!(free.len(), alone.len());
    for (alone, free) in alone.iter().zip(&free) {
        assert!((probability(alone, "pinch") - probability(free, "pinch")).abs() < 1e-9);
    }
}

#[test]
fn how_a_hand_changes_is_for_sequences_alone() {
    let sphere = pictures().join("camera/10-power-sphere.jpg");
    for option in [["--switch", "0.1"], ["--motion", "5"]] {
        let outcome = run(program("grasp-query").arg("recognise").arg(&sphere).args(option));
        assert_eq!(outcome.status, 2, "{option:?}");
        assert!(outcome.stderr.contains("--sequence"), "{}", outcome.stderr);
    }
}

#[test]
fn a_frame_without_a_hand_does_not_end_a_sequence() {
    let sphere = pictures().join("camera/10-power-sphere.jpg");
    let outcome = run(program("grasp-query")
        .args(["recognise", "--json", "--sequence", "--accept", "always", "--index"])
        .arg(small_index())
        .args([&sphere, &pictures().join("camera/no-hand.jpg"), &sphere]));
    let records = outcome.json_lines();
    assert_eq!((outcome.status, records.len()), (1, 3));
    assert_eq!(records[1]["error"]["kind"], "no_hand");
    assert!(records[2]["single"].is_object());
}

#[test]
fn what_is_held_counts_for_the_grasp() {
    let prior = pictures().join("prior.toml");
    let with = |object: &str, more: &[&str]| {
        let known = [&["--prior", prior.to_str().unwrap(), "--holding", object], more].concat();
        recognise(&["10-power-sphere.png", "10-power-sphere.png"], &known)
    };
    let alone = &recognise(&["10-power-sphere.png"], &[]).json_lines()[0];
    let ball = with("ball", &[]).json_lines();
    let (p, rest) = (probability(alone, "power-sphere"), |record: &Value| {
        let (ball, disc) = (probability(record, "power-sphere"), probability(record, "precision-disc"));
        0.8 * ball + 0.1 * disc + 0.025 * (1.0 - ball - disc)
    });
    assert!((probability(&ball[0], "power-sphere") - 0.8 * p / rest(alone)).abs() < 1e-9);
    assert_eq!(ball[0], {
        let mut second = ball[1].clone();
        second["file"] = ball[0]["file"].clone();
        second
    });
    // Over a sequence it counts once, not with every frame.
    let once = with("ball", &["--sequence"]).json_lines();
    assert!((probability(&once[0], "power-sphere") - probability(&ball[0], "power-sphere")).abs() < 1e-9);
    assert!(probability(&with("key", &[]).json_lines()[0], "pinch") > probability(alone, "pinch"));
}

#[test]
fn priors_that_cannot_be_used_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let told = |text: &str, object: &str| {
        std::fs::write(folder.path().join("p.toml"), text).unwrap();
        let outcome = run(program("grasp-query")
            .args(["recognise", "--segmented", "--prior", "p.toml", "--holding", object, "--index"])
            .arg(small_index())
            .arg(pictures().join("segmented/09-pinch.png"))
            .current_dir(folder.path()));
        assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""));
        outcome.stderr
    };
    assert!(told("[objects.cup]\npinch = 1.5", "cup").contains("pinch is 1.5: probabilities of 0 to 1"));
    assert!(
        told("[objects.cup]\nhook = 0.5", "cup")
            .contains("names the grasp `hook`; the index has large-diameter")
    );
    assert!(told("[objects.cup]", "mug").contains("the prior has no object `mug`; it has cup"));
    assert!(told("cup = 3", "cup").contains("the prior p.toml is not a table of [objects.NAME]"));
    let alone = recognise(&["09-pinch.png"], &["--prior", "p.toml"]);
    assert!(alone.status == 2 && alone.stderr.contains("--holding"), "{}", alone.stderr);
}

#[test]
fn views_at_all_stages_make_the_experiment() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = String::from("file,kind,grasp,stage,hand,azimuth,elevation,roll\n");
    for stage in ["reach", "close", "grasp"] {
        for (file, grasp) in [("09-pinch.png", "pinch"), ("10-power-sphere.png", "power-sphere")] {
            // One picture cannot be labelled with three stages.
            let name = format!("{stage}-{file}");
            std::fs::copy(pictures().join("segmented").join(file), folder.path().join(&name)).unwrap();
            table += &format!("{name},segmented,{grasp},{stage},right,0,0,0\n");
        }
    }
    let sequence = |table: &str, arguments: &[&str]| {
        std::fs::write(folder.path().join("l.csv"), table).unwrap();
        run(program("grasp-query")
            .args(["experiment", "sequence", "l.csv", "--hand", "right", "--json", "--out", "out", "--index"])
            .arg(small_index())
            .args(arguments)
            .current_dir(folder.path()))
    };
    let outcome = sequence(&table, &[]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let rows = outcome.json_lines()[0]["rows"].as_array().unwrap().clone();
    let stages: Vec<_> =
        rows.iter().map(|row| (row["stage"].as_str().unwrap(), row["n"].as_u64().unwrap())).collect();
    assert_eq!(stages, [("reach", 2), ("close", 2), ("grasp", 2)]);
    assert_eq!(rows[0]["alone_top1"], rows[0]["together_top1"]);
    assert!(folder.path().join("out/sequence.csv").is_file());

    // A picture that cannot be read takes its sequence with it.
    let outcome = sequence(&table.replacen("09-pinch.png", "missing.png", 1), &[]);
    let report = &outcome.json_lines()[0];
    assert_eq!((outcome.status, &report["rows"][2]["n"]), (2, &1.into()), "{report}");
    assert_eq!(report["errors"].as_array().unwrap().len(), 1);

    let refused = |table: &str, arguments: &[&str]| {
        let outcome = sequence(table, arguments);
        assert_eq!(outcome.status, 2, "{}", outcome.stdout);
        outcome.stderr
    };
    let said = refused(&table.replacen(",roll", ",angle", 1), &[]);
    assert!(said.contains("no column `roll`"), "{said}");
    let line = table.lines().nth(1).unwrap();
    let said = refused(&format!("{table}{line}\n"), &[]);
    assert!(said.contains("lines 2 and 8 of the labels show one view of pinch at the stage reach"), "{said}");
    assert!(refused(&table, &["--part", "final"]).contains("--part would divide"));
}
