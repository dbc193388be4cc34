//! `grasp-query recognise --robot`: what a robot does to make the same grasp, as text, JSON and a
//! message for MoveIt.

use std::fs;
use std::path::{Path, PathBuf};

use grasp_tests::{Outcome, pictures, program, run, small_index, workspace};
use serde_json::Value;

/// A ball that hangs in the air: as wide from every side, and nothing is in the way.
const BALL: &str = "name = 'ball'\nshape = 'sphere'\nradius = 0.03\nposition = [0.4, 0.1, 0.5]\nquaternion_xyzw = [0, 0, 0, 1]\n";
/// The camera of `camera.toml`.
const CAMERA: [f64; 4] = [-0.59637, 0.59637, -0.37993, 0.37993];

fn data(name: &str) -> PathBuf {
    workspace().join("query/data").join(name)
}

/// A folder with the ball, and the answer about a ball in a hand.
fn ball() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ball.toml"), BALL).unwrap();
    folder
}

fn recognise(folder: &Path, picture: &str, arguments: &[&str]) -> Outcome {
    seen_by(&data("objects/camera.toml"), folder, picture, arguments)
}

fn seen_by(camera: &Path, folder: &Path, picture: &str, arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["recognise", "--segmented", "--hand", "right", "--accept", "always", "--index"])
        .arg(small_index())
        .arg(pictures().join("segmented").join(picture))
        .arg("--camera")
        .arg(camera)
        .args(arguments)
        .current_dir(folder))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap_or_else(|| panic!("{value} is no list"));
    std::array::from_fn(|at| list[at].as_f64().unwrap())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector turned by a quaternion x, y, z, w.
fn turned([x, y, z, w]: [f64; 4], vector: [f64; 3]) -> [f64; 3] {
    let axis = [x, y, z];
    let once = cross(axis, vector);
    let twice = cross(axis, once);
    std::array::from_fn(|at| vector[at] + 2.0 * (w * once[at] + twice[at]))
}

#[track_caller]
fn assert_close(found: [f64; 3], expected: [f64; 3]) {
    let off = (0..3).map(|at| (found[at] - expected[at]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-4, "{found:?}, {expected:?} expected");
}

#[test]
fn a_strategy_follows_from_the_answer_beside_it() {
    let folder = ball();
    let picture = "10-power-sphere.png";
    let outcome =
        recognise(folder.path(), picture, &["--robot", "barrett", "--object", "ball.toml", "--json"]);
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    let record = &outcome.json_lines()[0];
    let strategy = &record["strategy"];
    assert_eq!(strategy["human_grasp"], record["grasp"]);
    assert_eq!((&record["grasp"], &strategy["grasp"]), (&"power-sphere".into(), &"wrap".into()));
    assert_eq!(
        (&strategy["object"], &strategy["allowed_touch_objects"][0]),
        (&"ball".into(), &"ball".into())
    );

    // The palm comes from where the back of the hand was: in the picture by the orientation, in the
    // world by the camera.
    let in_camera = turned(numbers(&record["orientation"]["quaternion_xyzw"]), [0.0, 0.0, -1.0]);
    let approach = turned(CAMERA, in_camera);
    assert_close(numbers(&strategy["approach_vector"]["vector"]), approach);
    for (pose, behind) in [("palm", 0.04), ("wrist", 0.12)] {
        assert_eq!(strategy[pose]["frame"], "object");
        assert_close(numbers(&strategy[pose]["position"]), approach.map(|part| -behind * part));
        let in_world = [0.4, 0.1, 0.5].iter().zip(approach).map(|(middle, part)| middle - behind * part);
        let in_world: Vec<f64> = in_world.collect();
        let found = &strategy[format!("{pose}_in_world")];
        assert_eq!(found["frame"], "world");
        assert_close(numbers(&found["position"]), [in_world[0], in_world[1], in_world[2]]);
        assert_close(turned(numbers(&found["quaternion_xyzw"]), [0.0, 0.0, 1.0]), approach);
    }
    let steps: Vec<_> = strategy["steps"].as_array().unwrap().iter().map(|step| &step["step"]).collect();
    assert_eq!(steps, ["preshape", "approach", "grasp", "retreat"]);
    let [start, end] = ["from", "to"].map(|end| numbers::<3>(&strategy["steps"][1][end]["position"]));
    assert_close(std::array::from_fn(|at| start[at] + 0.12 * approach[at]), end);

    // What is known beside what is tolerated.
    assert_eq!(strategy["estimate"]["position_m"], 0.01);
    let spread = record["orientation"]["spread_deg"].as_f64().unwrap().to_radians();
    assert!((strategy["estimate"]["orientation_rad"].as_f64().unwrap() - spread).abs() < 1e-9);
    let joints = |posture: &str| strategy[posture].as_object().unwrap().len();
    assert_eq!((joints("open"), joints("closed")), (8, 8));
}

#[test]
fn a_person_reads_what_the_hand_does() {
    let folder = ball();
    let picture = "10-power-sphere.png";
    let robot = ["--robot", "barrett", "--object", "ball.toml"];
    let text = recognise(folder.path(), picture, &robot);
    let json = recognise(folder.path(), picture, &[&robot[..], &["--json"]].concat());
    let strategy = &json.json_lines()[0]["strategy"];
    assert_eq!(text.status, 0, "{}", text.stderr);
    let [x, y, z] = numbers(&strategy["palm_in_world"]["position"]).map(|metres: f64| 1e3 * metres);
    let palm =
        format!("barrett: wrap on ball (60 mm between the fingers), palm at {x:.0}, {y:.0}, {z:.0} mm");
    assert!(text.stdout.contains(&palm), "{}", text.stdout);
    assert_eq!(strategy["problems"], serde_json::json!([]));
    for warning in strategy["warnings"].as_array().unwrap() {
        assert!(text.stdout.contains(&format!("warning: {}", warning.as_str().unwrap())), "{}", text.stdout);
    }
}

/// Keys with their parents, and values, of the block YAML that the program writes.
fn yaml(text: &str) -> Vec<(String, String)> {
    let mut parents: Vec<(usize, String)> = Vec::new();
    let mut found = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let item = line.replacen("- ", "  ", usize::from(line.trim_start().starts_with("- ")));
        let indent = item.len() - item.trim_start().len();
        parents.retain(|(other, _)| *other < indent);
        let (key, value) = item.trim_start().split_once(':').unwrap_or_else(|| panic!("{line} has no key"));
        let path: Vec<&str> = parents.iter().map(|(_, key)| key.as_str()).chain([key]).collect();
        found.push((path.join("."), value.trim().to_owned()));
        parents.push((indent, key.to_owned()));
    }
    found
}

#[test]
fn moveit_reads_the_same_strategy_as_a_message() {
    let folder = ball();
    let robot = ["--robot", "barrett", "--object", "ball.toml"];
    let second = pictures().join("segmented/09-pinch.png").display().to_string();
    let both = [&robot[..], &[&second]].concat();
    let messages =
        recognise(folder.path(), "10-power-sphere.png", &[&both[..], &["--format", "moveit"]].concat());
    let records = recognise(folder.path(), "10-power-sphere.png", &[&both[..], &["--json"]].concat());
    assert_eq!(messages.status, 0, "{}", messages.stderr);
    let documents: Vec<&str> = messages.stdout.split("---\n").skip(1).collect();
    let records = records.json_lines();
    assert_eq!((documents.len(), records.len()), (2, 2));
    for (document, record) in documents.iter().zip(&records) {
        let strategy = &record["strategy"];
        let fields = yaml(document);
        let value = |path: &str| -> Value {
            let found = fields.iter().find(|(key, _)| key == path);
            let (_, text) = found.unwrap_or_else(|| panic!("{path} is missing from {document}"));
            serde_json::from_str(text).unwrap_or_else(|error| panic!("{path}: {error} in {text}"))
        };
        let top = fields.iter().map(|(key, _)| key.as_str()).filter(|key| !key.contains('.'));
        let grasp = [
            "allowed_touch_objects",
            "grasp_pose",
            "grasp_posture",
            "grasp_quality",
            "id",
            "max_contact_force",
            "post_grasp_retreat",
            "post_place_retreat",
            "pre_grasp_approach",
            "pre_grasp_posture",
        ];
        assert_eq!(top.collect::<Vec<_>>(), grasp, "the fields of moveit_msgs/Grasp");
        assert_eq!(value("id"), record["file"]);
        // How sure the grasp is, and not how sure the human's class is.
        assert_eq!(strategy["feasible"], true);
        let quality = strategy["quality"].as_f64().unwrap_or_default();
        assert!((value("grasp_quality").as_f64().unwrap() - quality).abs() < 1e-6, "{document}");
        for warning in strategy["warnings"].as_array().unwrap() {
            let name = record["file"].as_str().unwrap();
            let line = format!("{name}: warning: {}\n", warning.as_str().unwrap());
            assert_eq!(messages.stderr.matches(&line).count(), 1, "{}", messages.stderr);
        }
        assert_eq!(value("grasp_pose.header.frame_id"), "world");
        let parts = |of: &str, names: &[&str]| -> Vec<f64> {
            names.iter().map(|name| value(&format!("{of}.{name}")).as_f64().unwrap()).collect()
        };
        let position = parts("grasp_pose.pose.position", &["x", "y", "z"]);
        let rotation = parts("grasp_pose.pose.orientation", &["x", "y", "z", "w"]);
        let wrist = &strategy["wrist_in_world"];
        let expected =
            [&numbers::<3>(&wrist["position"])[..], &numbers::<4>(&wrist["quaternion_xyzw"])].concat();
        for (found, expected) in position.iter().chain(&rotation).zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{document}");
        }
        for (field, posture) in [("pre_grasp_posture", "open"), ("grasp_posture", "closed")] {
            let names = value(&format!("{field}.joint_names"));
            let joints: Vec<&String> = strategy[posture].as_object().unwrap().keys().collect();
            assert_eq!(names, serde_json::json!(joints));
            assert_eq!(value(&format!("{field}.points.positions")).as_array().unwrap().len(), joints.len());
        }
        // Forward is the wrist's own z, up is the world's.
        assert_eq!(value("pre_grasp_approach.direction.header.frame_id"), strategy["wrist_link"]);
        assert_eq!(parts("pre_grasp_approach.direction.vector", &["x", "y", "z"]), [0.0, 0.0, 1.0]);
        assert_eq!(value("post_grasp_retreat.direction.header.frame_id"), "world");
        assert_eq!(parts("post_grasp_retreat.direction.vector", &["x", "y", "z"]), [0.0, 0.0, 1.0]);
        // And back the way it came once it has let go.
        assert_eq!(value("post_place_retreat.direction.header.frame_id"), strategy["wrist_link"]);
        assert_eq!(parts("post_place_retreat.direction.vector", &["x", "y", "z"]), [0.0, 0.0, -1.0]);
        assert_eq!(value("allowed_touch_objects"), serde_json::json!(["ball"]));
    }
}

/// A camera 0.8 m before the ball that sees the hand come along the world's z, where it sees it
/// come along `approach` in its own frame.
fn camera_from_below(folder: &Path, approach: [f64; 3]) -> PathBuf {
    let axis = cross(approach, [0.0, 0.0, 1.0]);
    let quaternion = [axis[0], axis[1], axis[2], 1.0 + approach[2]];
    let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
    let path = folder.join("below.toml");
    let quaternion = quaternion.map(|part| part / length);
    let forward = turned(quaternion, [0.0, 0.0, 1.0]);
    let position: [f64; 3] = std::array::from_fn(|at| [0.4, 0.1, 0.5][at] - 0.8 * forward[at]);
    fs::write(
        &path,
        format!("position = {position:?}\nquaternion_xyzw = {quaternion:?}\nposition_spread = 0.01\n"),
    )
    .unwrap();
    path
}

#[test]
fn what_no_robot_should_try_is_refused_where_it_is_seen() {
    let folder = ball();
    // The table is well below the ball, and the hand comes through it.
    fs::write(folder.path().join("standing.toml"), format!("{BALL}table = 0.42\n")).unwrap();
    let picture = "10-power-sphere.png";
    let robot = ["--robot", "barrett", "--object", "standing.toml"];
    let record = &recognise(folder.path(), picture, &[&robot[..], &["--json"]].concat()).json_lines()[0];
    let approach = turned(numbers(&record["orientation"]["quaternion_xyzw"]), [0.0, 0.0, -1.0]);
    let below = camera_from_below(folder.path(), approach);
    let centimetres = folder.path().join("centimetres.toml");
    let camera = fs::read_to_string(data("objects/camera.toml")).unwrap();
    fs::write(&centimetres, format!("{camera}hand = [-6.0, 2.0, 75.0]\n")).unwrap();

    for (camera, kind, words) in [
        (&below, "below_table", "below the surface of the table"),
        (&centimetres, "hand_away", "m beside ball"),
    ] {
        let ask = |form: &[&str]| seen_by(camera, folder.path(), picture, &[&robot[..], form].concat());
        let json = ask(&["--json"]);
        let strategy = &json.json_lines()[0]["strategy"];
        assert_eq!((json.status, &strategy["feasible"]), (1, &Value::Bool(false)), "{strategy}");
        assert_eq!((&strategy["problems"][0]["kind"], &strategy["quality"]), (&kind.into(), &0.0.into()));
        let message = strategy["problems"][0]["message"].as_str().unwrap();
        assert!(message.contains(words), "{message}");
        let text = ask(&[]);
        assert_eq!(text.status, 1);
        assert_eq!(text.stdout.matches(message).count(), 1, "{}", text.stdout);
        assert!(text.stdout.contains(&format!("not feasible: {message}")), "{}", text.stdout);
        // A message would be carried out by whoever reads it: there is none.
        let moveit = ask(&["--format", "moveit"]);
        assert_eq!((moveit.status, moveit.stdout.as_str()), (1, ""));
        assert!(moveit.stderr.contains(message), "{}", moveit.stderr);
    }
    // An arm that stands 3 m away.
    let arm = fs::read_to_string(data("arms/kuka-kr6-r700.toml")).unwrap();
    fs::write(folder.path().join("far.toml"), arm.replacen("[-0.15, 0.0, 0.0]", "[-3.0, 0.0, 0.0]", 1))
        .unwrap();
    let ball = ["--robot", "barrett", "--object", "ball.toml", "--arm", "far.toml"];
    let far = recognise(folder.path(), picture, &[&ball[..], &["--format", "moveit"]].concat());
    assert_eq!((far.status, far.stdout.as_str()), (1, ""));
    assert!(far.stderr.contains("unreachable: kuka-kr6-r700"), "{}", far.stderr);
}

#[test]
fn another_hand_is_a_name_or_a_file() {
    let folder = ball();
    let with = |hand: &str| {
        let arguments = ["--robot", hand, "--object", "ball.toml", "--json"];
        let outcome = recognise(folder.path(), "10-power-sphere.png", &arguments);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        outcome.json_lines()[0]["strategy"].clone()
    };
    let gripper = with("parallel-gripper");
    assert_eq!((&gripper["robot"], &gripper["grasp"]), (&"parallel-gripper".into(), &"parallel".into()));
    assert_eq!(gripper["open"]["gripper_left_finger_joint"], 0.04);
    assert!(gripper["tolerated"].is_null());
    assert!(
        gripper["warnings"].as_array().unwrap().iter().any(|warning| {
            warning == "what error the grasp tolerates is not known: it was never simulated"
        })
    );

    let description = fs::read_to_string(data("robots/parallel-gripper.toml")).unwrap();
    let longer = description.replace("\"parallel-gripper\"", "\"long\"").replace("0.095]", "0.195]");
    fs::write(folder.path().join("long.toml"), longer).unwrap();
    let long = with("long.toml");
    assert_eq!((&long["robot"], &long["palm"]), (&"long".into(), &gripper["palm"]));
    let approach: [f64; 3] = numbers(&long["approach_vector"]["vector"]);
    let wrist: [f64; 3] = numbers(&gripper["wrist"]["position"]);
    assert_close(
        numbers(&long["wrist"]["position"]),
        std::array::from_fn(|at| wrist[at] - 0.1 * approach[at]),
    );
}

#[test]
fn a_gripper_is_described_by_its_urdf_and_a_file_beside_it() {
    let folder = ball();
    let urdf = workspace().join("query/robot/tests/urdf/slider.urdf");
    let with = |hand: &str, form: &[&str]| {
        let arguments = [&["--robot", hand, "--object", "ball.toml"], form].concat();
        recognise(folder.path(), "10-power-sphere.png", &arguments)
    };
    let found = with(urdf.to_str().unwrap(), &["--json"]);
    assert_eq!(found.status, 0, "{}", found.stderr);
    let strategy = &found.json_lines()[0]["strategy"];
    assert_eq!((&strategy["robot"], &strategy["wrist_link"]), (&"slider".into(), &"base".into()));
    // 60 mm between the pads and 20 more are more than they open: as far as they go.
    assert_eq!(strategy["open"]["left_slide"], 0.035);
    assert_eq!(strategy["layout"]["fingers"].as_array().unwrap().len(), 2);
    let message = with(urdf.to_str().unwrap(), &["--format", "moveit"]);
    assert!(message.status == 0 && message.stdout.contains("[\"left_slide\"]"), "{}", message.stdout);

    fs::copy(&urdf, folder.path().join("alone.urdf")).unwrap();
    let alone = with("alone.urdf", &[]);
    assert_eq!((alone.status, alone.stdout.as_str()), (2, ""));
    assert!(alone.stderr.contains("write alone.toml, which does"), "{}", alone.stderr);
}

#[test]
fn a_grasp_that_this_hand_cannot_do_leaves_the_answer() {
    let folder = ball();
    fs::write(folder.path().join("wide.toml"), BALL.replace("0.03", "0.1")).unwrap();
    let robot = ["--robot", "parallel-gripper", "--object", "wide.toml"];
    let json = recognise(folder.path(), "10-power-sphere.png", &[&robot[..], &["--json"]].concat());
    let record = &json.json_lines()[0];
    assert_eq!((json.status, &record["grasp"]), (2, &"power-sphere".into()));
    assert_eq!(record["error"]["kind"], "too_wide");
    assert!(record["strategy"].is_null());
    let moveit =
        recognise(folder.path(), "10-power-sphere.png", &[&robot[..], &["--format", "moveit"]].concat());
    assert_eq!((moveit.status, moveit.stdout.as_str()), (2, ""));
    assert!(moveit.stderr.contains("parallel-gripper opens to 75 mm"), "{}", moveit.stderr);
    // 200 mm are more than any hand here takes, and none is recommended for it.
    assert!(!moveit.stderr.contains("opens wider"), "{}", moveit.stderr);
    let barrett = ["--robot", "barrett", "--object", "wide.toml", "--format", "moveit"];
    let barrett = recognise(folder.path(), "10-power-sphere.png", &barrett);
    assert!(barrett.status == 2 && barrett.stderr.contains("opens to 175 mm"), "{}", barrett.stderr);
}

#[test]
fn what_describes_nothing_real_is_refused_before_any_picture() {
    let folder = ball();
    let bottle = fs::read_to_string(data("objects/bottle.toml")).unwrap();
    let camera = fs::read_to_string(data("objects/camera.toml")).unwrap();
    let hand = fs::read_to_string(data("robots/barrett.toml")).unwrap();
    let changed = [
        ("no-size.toml", bottle.replace("radius = 0.035\n", "")),
        ("no-rotation.toml", bottle.replace("0.0, 0.0, 0.0, 1.0", "0.0, 0.0, 0.7, 1.0")),
        ("in-table.toml", bottle.replace("0.08]", "0.05]")),
        ("no-toml.toml", "shape: sphere".to_owned()),
        ("lens.toml", camera.replace("0.37993, 0.37993", "0.37993, 0.97993")),
        ("hand.toml", hand.replace("pinch = \"two-finger-thumb\"", "pinch = \"poke\"")),
    ];
    for (name, text) in &changed {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let with = |robot: &str, object: &str, more: &[&str]| {
        let arguments = [&["--robot", robot, "--object", object], more].concat();
        let outcome = recognise(folder.path(), "10-power-sphere.png", &arguments);
        assert_eq!(
            (outcome.status, outcome.stdout.as_str()),
            (2, ""),
            "{robot} {object}: {}",
            outcome.stderr
        );
        outcome.stderr
    };
    let mut said = vec![
        with("barrett", "no-size.toml", &[]),
        with("barrett", "no-rotation.toml", &["--json"]),
        with("barrett", "in-table.toml", &[]),
        with("barrett", "no-toml.toml", &[]),
        with("barrett", "missing.toml", &[]),
        with("shadow", "ball.toml", &[]),
        with("hand.toml", "ball.toml", &["--format", "moveit"]),
    ];
    // Turned half about its own x, it looks away from the ball.
    let away =
        camera.replace("[-0.59637, 0.59637, -0.37993, 0.37993]", "[-0.59637, -0.59637, 0.37993, 0.37993]");
    assert_ne!(away, camera);
    fs::write(folder.path().join("away.toml"), away).unwrap();
    for camera in ["lens.toml", "away.toml"] {
        let outcome = run(program("grasp-query")
            .args(["recognise", "--robot", "barrett", "--object", "ball.toml", "--camera", camera, "x.png"])
            .arg("--index")
            .arg(small_index())
            .current_dir(folder.path()));
        assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""));
        said.push(outcome.stderr);
    }
    insta::assert_snapshot!(said.concat());

    let alone = run(program("grasp-query").args(["recognise", "--robot", "barrett", "x.png"]));
    assert!(alone.status == 2 && alone.stderr.contains("--object <OBJECT.toml>"), "{}", alone.stderr);
}
