//! A strategy in the shape of a `moveit_msgs/Grasp` message, as values and as YAML.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::pose::{Direction, Pose, rounded};
use super::step::Step;
use super::strategy::Strategy;

/// What begins a comment that warns.
const WARNING: &str = "# warning: ";

/// The warnings of a document: they are for a person, who may not read its comments.
pub fn warnings(yaml: &str) -> impl Iterator<Item = &str> {
    yaml.lines().filter_map(|line| line.strip_prefix(WARNING))
}

/// The message of one strategy as a YAML document, with its leading `---`.
///
/// Poses are those of the wrist, the end effector's parent link. What the message has no field for,
/// the estimate's spread, the tolerated window and warnings, stands before it as comments.
/// `grasp_quality` is the strategy's, and 0, the message's own default, where that is unknown.
pub fn yaml(strategy: &Strategy, id: &str) -> String {
    let mut text = String::from("---\n");
    let mut comment = |line: String| {
        // A name may hold what ends a line, and with it the comment.
        let _ = writeln!(text, "# {}", line.replace(is_special, " "));
    };
    comment(format!(
        "{} of {}, like {}, on {}",
        strategy.grasp, strategy.robot, strategy.human_grasp, strategy.object
    ));
    let estimate = &strategy.estimate;
    let position = estimate.position_m.map_or("unknown".into(), |m| format!("{m:.3} m"));
    comment(format!(
        "estimate: position {position} ({}), orientation {:.3} rad",
        estimate.hand_position, estimate.orientation_rad
    ));
    comment(match &strategy.tolerated {
        Some(window) => {
            let turn = |turn: Option<f64>| turn.map_or("unknown".into(), |turn| format!("+-{turn:.3} rad"));
            format!(
                "tolerated: position +-{:.3} m, yaw {}, tilt {}, roll {} ({}, {})",
                window.position_m,
                turn(window.yaw_rad),
                turn(window.tilt_rad),
                turn(window.roll_rad),
                window.object,
                window.engine
            )
        }
        None => "tolerated: unknown".into(),
    });
    if let Some(arm) = strategy.arm.as_ref().filter(|arm| arm.reachable) {
        comment(format!("arm: {} reaches all of it", arm.arm));
    }
    comment(match strategy.quality {
        Some(_) => {
            "grasp_quality: the probability that the estimate's error stays within what is tolerated".into()
        }
        None => {
            "grasp_quality: not known, and so 0: it needs the position's spread and what is tolerated".into()
        }
    });
    let described = strategy.max_contact_force;
    comment(match simulated_force(strategy) {
        Some(force) => format!(
            "max_contact_force: the hand's description; simulated, one link pressed with up to {force:.0} N, as nothing keeps it to {described} N"
        ),
        None => "max_contact_force: the hand's description; how hard it presses was never simulated".into(),
    });
    for warning in &strategy.warnings {
        comment(format!("warning: {warning}"));
    }
    block(&message(strategy, id), 0, &mut text);
    text
}

fn simulated_force(strategy: &Strategy) -> Option<f64> {
    strategy.steps.iter().find_map(|step| match step {
        Step::Grasp { simulated_force, .. } => *simulated_force,
        _ => None,
    })
}

/// The message of one strategy, its fields by their names. What ROS fills in by itself is left out:
/// stamps, and velocities and accelerations of postures.
///
/// `grasp_quality` is the strategy's, and 0, the message's own default, where that is unknown.
pub fn message(strategy: &Strategy, id: &str) -> Value {
    let mut approach = Value::Null;
    let mut retreat = Value::Null;
    let mut release = Value::Null;
    for step in &strategy.steps {
        match step {
            // MoveIt moves along a direction of the hand's own; the hand is turned so that this is
            // the approach vector.
            Step::Approach { distance, min_distance, .. } => {
                let [wrist, palm] = [&strategy.wrist, &strategy.palm].map(|pose| pose.isometry().rotation);
                let vector = wrist.inverse() * palm * Vector3::z();
                let along = |vector: Vector3<f64>| {
                    let direction = Direction { frame: strategy.wrist_link.clone(), vector: vector.into() };
                    translation(&direction, *distance, *min_distance)
                };
                approach = along(vector);
                // A hand that has let go leaves as it came: upward, a finger below the object would
                // take it along.
                release = along(-vector);
            }
            Step::Retreat { direction, distance, min_distance } => {
                retreat = translation(direction, *distance, *min_distance);
            }
            Step::Preshape { .. } | Step::Grasp { .. } => {}
        }
    }
    let mut message = serde_json::Map::new();
    message.insert("id".into(), json!(id));
    message.insert("pre_grasp_posture".into(), posture(&strategy.open));
    message.insert("grasp_posture".into(), posture(&strategy.closed));
    message.insert("grasp_pose".into(), pose(&strategy.wrist_in_world));
    message.insert("grasp_quality".into(), json!(rounded(strategy.quality.unwrap_or_default())));
    message.insert("pre_grasp_approach".into(), approach);
    message.insert("post_grasp_retreat".into(), retreat);
    message.insert("post_place_retreat".into(), release);
    message.insert("max_contact_force".into(), json!(strategy.max_contact_force));
    message.insert("allowed_touch_objects".into(), json!(strategy.allowed_touch_objects));
    Value::Object(message)
}

fn header(frame: &str) -> Value {
    json!({ "frame_id": frame })
}

fn xyz(vector: [f64; 3]) -> Value {
    let [x, y, z] = vector.map(rounded);
    json!({ "x": x, "y": y, "z": z })
}

fn pose(pose: &Pose) -> Value {
    let [x, y, z, w] = pose.quaternion_xyzw.map(rounded);
    json!({
        "header": header(pose.frame),
        "pose": { "position": xyz(pose.position), "orientation": { "x": x, "y": y, "z": z, "w": w } },
    })
}

fn translation(direction: &Direction, desired: f64, least: f64) -> Value {
    json!({
        "direction": { "header": header(&direction.frame), "vector": xyz(direction.vector) },
        "desired_distance": desired,
        "min_distance": least,
    })
}

/// A posture without efforts: those of a turning joint would be torques, and what is known is a
/// force.
fn posture(joints: &BTreeMap<String, f64>) -> Value {
    let positions: Vec<f64> = joints.values().copied().map(rounded).collect();
    json!({
        "joint_names": joints.keys().collect::<Vec<_>>(),
        "points": [{ "positions": positions, "effort": [], "time_from_start": { "sec": 1, "nanosec": 0 } }],
    })
}

/// A value as block YAML; strings and lists of numbers are written nearly as JSON.
fn block(value: &Value, indent: usize, text: &mut String) {
    let space = " ".repeat(indent);
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let _ = write!(text, "{space}{key}:");
                match value {
                    Value::Object(_) => {
                        text.push('\n');
                        block(value, indent + 2, text);
                    }
                    Value::Array(items) if items.iter().any(Value::is_object) => {
                        text.push('\n');
                        for item in items {
                            let mut inner = String::new();
                            block(item, indent + 4, &mut inner);
                            // The first key stands behind the dash.
                            let _ = write!(text, "{space}  - {}", inner.trim_start());
                        }
                    }
                    value => {
                        let _ = writeln!(text, " {}", leaf(value));
                    }
                }
            }
        }
        value => {
            let _ = writeln!(text, "{space}{}", leaf(value));
        }
    }
}

/// A number, a string or a list of them as JSON has it, but for what YAML 1.1, which ROS reads,
/// takes otherwise: 1e-6 is a string to it, and some characters have to be escaped.
fn leaf(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(leaf).collect::<Vec<_>>().join(",")),
        Value::Number(number) => match (number.to_string(), number.as_f64()) {
            (text, Some(value)) if text.contains('e') => value.to_string(),
            (text, _) => text,
        },
        other => {
            let escaped = |c: char| match is_special(c) {
                true => format!("\\u{:04x}", u32::from(c)),
                false => c.to_string(),
            };
            other.to_string().chars().map(escaped).collect()
        }
    }
}

/// Whether a character ends a line in YAML 1.1, or may not stand in it at all.
fn is_special(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
}
