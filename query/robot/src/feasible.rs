//! What cannot be right about a strategy: nobody should try it, however sure the estimate is.

use nalgebra::Point3;
use serde::Serialize;

use super::layout::Layout;
use super::{Object, RobotHand};

/// Farther than this from the object, in metres, the human hand hardly held it.
const BESIDE: f64 = 0.05;
/// Farther than this, the length of a hand, it did not hold it.
const AWAY: f64 = 0.20;
/// How deep in the table the palm may seem to be before that is a problem, in metres: what a
/// measurement may be wrong by.
const PALM_IN_TABLE: f64 = 0.01;
/// The same of fingers, which give way where they meet it: in simulation a ball was held by a hand
/// so tilted that its fingers would have been 24 mm in the table.
const FINGER_IN_TABLE: f64 = 0.03;

/// Why a strategy cannot be carried out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Problem {
    /// A short, stable name.
    pub kind: ProblemKind,
    /// What would happen and what to check.
    pub message: String,
}

/// What cannot be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum ProblemKind {
    /// The palm or the fingers would be in the table or under it.
    BelowTable,
    /// The human hand was not at the object.
    HandAway,
    /// The robot's fingers would not reach the object.
    PalmAway,
    /// The arm cannot carry the hand along the whole way.
    Unreachable,
}

/// What was found: the problems, and what is merely doubtful.
#[derive(Debug, Default)]
pub(super) struct Findings {
    pub(super) problems: Vec<Problem>,
    pub(super) doubts: Vec<String>,
}

impl Findings {
    /// Of a hand that closes as `layout` says, aimed at `grip`, where the human hand closed.
    pub(super) fn new(hand: &RobotHand, object: &Object, layout: &Layout, grip: Point3<f64>) -> Self {
        let mut findings = Self::default();
        findings.look_for_object(hand, object, layout, grip);
        // A palm that is astray is beside the table as well.
        if findings.problems.is_empty() {
            findings.look_for_table(layout);
        }
        findings
    }

    fn look_for_object(&mut self, hand: &RobotHand, object: &Object, layout: &Layout, grip: Point3<f64>) {
        let distance = |point: Point3<f64>| {
            let world_from_object = layout.object.pose.isometry();
            object.shape.distance(&world_from_object.inverse_transform_point(&point))
        };
        let beside = distance(grip);
        let name = &object.name;
        if beside > BESIDE {
            let message = format!(
                "the hand held something {} beside {name}: check the positions of hand, camera and object, which are in metres",
                length(beside)
            );
            if beside > AWAY {
                return self.problem(ProblemKind::HandAway, message);
            }
            self.doubts.push(message);
        }
        let gap = distance(layout.palm());
        let reach = hand.reach();
        if gap > reach {
            self.problem(
                ProblemKind::PalmAway,
                format!(
                    "the palm would stay {} away from {name}, and its fingers reach {}: check the positions of hand, camera and object, which are in metres",
                    length(gap),
                    length(reach)
                ),
            );
        }
    }

    fn look_for_table(&mut self, layout: &Layout) {
        let Some(table) = layout.table else { return };
        let [palm, start] = layout.lowest_of_palm().map(|lowest| table - lowest);
        let finger = layout.lowest_of_fingers().map_or(f64::NEG_INFINITY, |lowest| table - lowest);
        let parts = [
            ("the palm", palm, PALM_IN_TABLE),
            ("the palm, where the approach begins,", start, PALM_IN_TABLE),
            ("a finger", finger, FINGER_IN_TABLE),
        ];
        let deepest = parts
            .into_iter()
            .filter(|(_, depth, most)| depth > most)
            .max_by(|(_, one, _), (_, other, _)| one.total_cmp(other));
        if let Some((part, depth, _)) = deepest {
            let message = format!(
                "{part} would be {} below the surface of the table: the orientation of the hand or the pose of the camera is likely wrong",
                length(depth)
            );
            self.problem(ProblemKind::BelowTable, message);
        } else if finger > 0.0 {
            self.doubts.push(format!(
                "a finger would press on the table, by {}: lift the palm, or let the fingers give way",
                length(finger)
            ));
        }
    }

    fn problem(&mut self, kind: ProblemKind, message: String) {
        self.problems.push(Problem { kind, message });
    }
}

/// A length as people write it.
fn length(metres: f64) -> String {
    if metres < 1.0 { format!("{:.0} mm", 1e3 * metres) } else { format!("{metres:.1} m") }
}
