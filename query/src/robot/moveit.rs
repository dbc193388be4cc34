//! A strategy in the shape of a `moveit_msgs/Grasp` message, as YAML.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};

use super::strategy::{Direction, Pose, Step, Strategy};
use crate::output::record::Answer;

/// The YAML document of an answer, where it has a strategy.
pub fn of_answer(answer: &Answer) -> Option<String> {
    let id = answer.frame.map_or_else(|| answer.file.clone(), |frame| format!("{} {frame}", answer.file));
    answer.strategy.as_ref().map(|strategy| yaml(strategy, &id, answer.probability))
}

/// The message of one strategy as a YAML document, with its leading `---`.
///
/// Poses are those of the wrist, the end effector's parent link. What the message has no field for, the estimate's
/// spread, the tolerated window and warnings, stands before it as comments.
pub fn yaml(strategy: &Strategy, id: &str, probability: f64) -> String {
    let mut text = String::from("---\n");
    let mut comment = |line: String| {
        // A name may hold a line break, which would end the comment.
        let _ = writeln!(text, "# {}", line.replace(['\n', '\r'], " "));
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
        Some(window) => format!(
            "tolerated: position +-{:.3} m, yaw {}, tilt {} ({}, {})",
            window.position_m,
            window.yaw_rad.map_or("any".into(), |yaw| format!("+-{yaw:.3} rad")),
            window.tilt_rad.map_or("unknown".into(), |tilt| format!("+-{tilt:.3} rad")),
            window.object,
            window.engine
        ),
        None => "tolerated: unknown".into(),
    });
    if let Some(arm) = strategy.arm.as_ref().filter(|arm| arm.reachable) {
        comment(format!("arm: {} reaches all of it", arm.arm));
    }
    for warning in &strategy.warnings {
        comment(format!("warning: {warning}"));
    }
    block(&message(strategy, id, probability), 0, &mut text);
    text
}

fn message(strategy: &Strategy, id: &str, probability: f64) -> Value {
    let mut approach = Value::Null;
    let mut retreat = Value::Null;
    for step in &strategy.steps {
        match step {
            // MoveIt moves along the hand's own z; the hand is turned so that this is the approach vector.
            Step::Approach { distance, min_distance, .. } => {
                let forward = Direction { frame: strategy.wrist_link.clone(), vector: [0.0, 0.0, 1.0] };
                approach = translation(&forward, *distance, *min_distance);
            }
            Step::Retreat { direction, distance, min_distance } => {
                retreat = translation(direction, *distance, *min_distance);
            }
            Step::Preshape { .. } | Step::Grasp { .. } => {}
        }
    }
    let mut message = serde_json::Map::new();
    message.insert("id".into(), json!(id));
    message.insert("pre_grasp_posture".into(), posture(&strategy.open, None));
    message.insert("grasp_posture".into(), posture(&strategy.closed, Some(strategy.max_contact_force)));
    message.insert("grasp_pose".into(), pose(&strategy.wrist_in_world));
    message.insert("grasp_quality".into(), json!(probability));
    message.insert("pre_grasp_approach".into(), approach);
    message.insert("post_grasp_retreat".into(), retreat.clone());
    // Setting the object down again is that way back.
    message.insert("post_place_retreat".into(), retreat);
    message.insert("max_contact_force".into(), json!(strategy.max_contact_force));
    message.insert("allowed_touch_objects".into(), json!(strategy.allowed_touch_objects));
    Value::Object(message)
}

fn header(frame: &str) -> Value {
    json!({ "frame_id": frame })
}

/// To a micrometre or microradian: what lies beyond is noise that would differ between machines. Never -0.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
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

fn posture(joints: &BTreeMap<String, f64>, effort: Option<f64>) -> Value {
    let positions: Vec<f64> = joints.values().copied().map(rounded).collect();
    let effort = effort.map(|effort| vec![effort; joints.len()]).unwrap_or_default();
    json!({
        "joint_names": joints.keys().collect::<Vec<_>>(),
        "points": [{ "positions": positions, "effort": effort, "time_from_start": { "sec": 1, "nanosec": 0 } }],
    })
}

/// A value as block YAML; strings and lists of numbers are written as JSON, which YAML contains.
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
                    leaf => {
                        let _ = writeln!(text, " {leaf}");
                    }
                }
            }
        }
        leaf => {
            let _ = writeln!(text, "{space}{leaf}");
        }
    }
}
