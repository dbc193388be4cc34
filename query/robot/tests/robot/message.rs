//! What MoveIt and whoever closes the fingers are told.

use grasp_robot::{Object, Step, Strategy, moveit};

use super::{BOTTLE, bottle, camera, hand, seen, upright};

#[test]
fn a_hand_that_lets_go_leaves_as_it_came() {
    let camera = camera();
    for name in ["barrett", "allegro"] {
        let seen = seen("large-diameter", upright(), &camera);
        let found = Strategy::new(&hand(name), &seen, &bottle(), &camera).unwrap();
        let message = moveit::message(&found, "cup.jpg");
        let way = |key: &str, axis: &str| message[key]["direction"]["vector"][axis].as_f64().unwrap();
        for axis in ["x", "y", "z"] {
            assert_eq!(way("post_place_retreat", axis), -way("pre_grasp_approach", axis), "{name}");
        }
        let [came, left] = ["pre_grasp_approach", "post_place_retreat"].map(|key| &message[key]);
        assert_eq!(left["direction"]["header"], came["direction"]["header"]);
        assert_eq!(left["desired_distance"], came["desired_distance"]);
        assert_eq!(message["post_grasp_retreat"]["direction"]["header"]["frame_id"], "world");
    }
}

#[test]
fn the_force_that_was_simulated_is_said_beside_the_one_that_is_described() {
    let camera = camera();
    let seen = seen("large-diameter", upright(), &camera);
    let grasp = |name: &str| {
        let strategy = Strategy::new(&hand(name), &seen, &bottle(), &camera).unwrap();
        let step = strategy.steps.into_iter().find_map(|step| match step {
            Step::Grasp { max_contact_force, simulated_force, .. } => {
                Some((max_contact_force, simulated_force))
            }
            _ => None,
        });
        step.unwrap()
    };
    assert_eq!(grasp("barrett"), (20.0, Some(110.0)));
    assert_eq!(grasp("parallel-gripper"), (40.0, None));
}

#[test]
fn moveit_gets_the_wrist_in_the_world() {
    let camera = camera();
    let strategy =
        Strategy::new(&hand("parallel-gripper"), &seen("pinch", upright(), &camera), &bottle(), &camera)
            .unwrap();
    insta::assert_snapshot!(moveit::yaml(&strategy, "cup.jpg"));
}

/// As PyYAML reads it, and with it ROS: a float needs a point where it has an exponent, and what is
/// no printable character has to be escaped.
#[test]
fn a_message_is_read_as_it_was_meant() {
    let camera = camera();
    let name = "a\u{7f}\u{85}\u{2028}\u{fffe} \u{e9}";
    let text = BOTTLE.replace("name = \"bottle\"", &format!("name = {}", serde_json::json!(name)));
    let text = text.replace('\u{7f}', "\\u007f");
    let object = Object::parse("own.toml", &text).unwrap();
    assert_eq!(object.name, name);
    let mut found =
        Strategy::new(&hand("barrett"), &seen("pinch", upright(), &camera), &object, &camera).unwrap();
    found.quality = Some(4e-6);
    found.wrist_in_world.position[1] = -2e-6;
    found.closed.insert("joint".into(), 3e-6);
    let yaml = moveit::yaml(&found, "cup.jpg");
    let line = |key: &str| yaml.lines().find_map(|line| line.trim().strip_prefix(key)).unwrap().trim();
    assert_eq!(line("grasp_quality:"), "0.000004");
    assert!(yaml.contains("y: -0.000002\n") && yaml.contains(",0.000003]"), "{yaml}");
    assert_eq!(line("allowed_touch_objects:"), r#"["a\u007f\u0085\u2028\ufffe é"]"#);
    assert!(!yaml.contains(['\u{7f}', '\u{85}', '\u{2028}', '\u{fffe}']), "{yaml}");
}
