//! What cannot be right about a strategy: nobody should try it, however sure the estimate is.

use nalgebra::Point3;
use serde::Serialize;

use super::Object;
use super::closing::Closing;
use super::layout::Layout;

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

/// How deep in the object open fingers of both sides may seem to be before it does not go between
/// them, in metres: half of a finger's thickness. In simulation boxes into which less than that
/// went were pushed back a little, and held.
const FINGER_IN_OBJECT: f64 = 0.010;
/// From so deep on, in metres, what is measured to a millimetre is worth a word.
const TOUCHES: f64 = 0.001;
/// How far from the palm something may be that a hand grasps whose description has no fingers, in
/// metres.
const ORDINARY_REACH: f64 = 0.20;

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
    /// The robot's fingers would not reach the object, or those of one side only.
    PalmAway,
    /// The object would not go between the robot's open fingers.
    InObject,
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
    /// Of a hand that closes as `layout` says, and `closing` for its fingers, where they are known;
    /// aimed at `grip`, where the human hand closed.
    pub(super) fn new(object: &Object, layout: &Layout, closing: Option<Closing>, grip: Point3<f64>) -> Self {
        let mut findings = Self::default();
        findings.look_for_object(object, layout, closing, grip);
        // A palm that is astray is beside the table as well.
        if findings.problems.is_empty() {
            findings.look_for_table(layout);
        }
        findings
    }

    fn look_for_object(
        &mut self,
        object: &Object,
        layout: &Layout,
        closing: Option<Closing>,
        grip: Point3<f64>,
    ) {
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
        match closing {
            Some(closing) if !closing.meets() => {
                let missed = match closing.farther() {
                    Some(metres) => format!("come no nearer than {} to it from both sides", length(metres)),
                    None => "are all on one side of it".to_owned(),
                };
                self.problem(
                    ProblemKind::PalmAway,
                    format!(
                        "the palm would stay {} away from {name}, and its fingers, closing, {missed}: check the positions of hand, camera and object, or approach it less tilted",
                        length(gap)
                    ),
                );
            }
            Some(closing) => self.look_between_fingers(name, closing),
            None if gap > ORDINARY_REACH => self.problem(
                ProblemKind::PalmAway,
                format!(
                    "the palm would stay {} away from {name}, and a hand reaches {}: check the positions of hand, camera and object, which are in metres",
                    length(gap),
                    length(ORDINARY_REACH)
                ),
            ),
            None => {}
        }
    }

    fn look_between_fingers(&mut self, name: &str, closing: Closing) {
        let [one, other] = closing.inside;
        if one.min(other) > FINGER_IN_OBJECT {
            self.problem(
                ProblemKind::InObject,
                format!(
                    "{name} does not go between the open fingers, which would be {} inside it: take a hand that opens wider, or approach it from another side",
                    length(one.max(other))
                ),
            );
        } else if one.max(other) > TOUCHES {
            self.doubts.push(format!(
                "an open finger would be {} inside {name}, and push it away on the approach",
                length(one.max(other))
            ));
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
