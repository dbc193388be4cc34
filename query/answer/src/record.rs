//! The JSON record of one input. Its keys are an interface: they may be added to, never renamed.

use grasp_index::{EntryError, Index, Neighbour};
use serde::Serialize;

use grasp_recognise::orientation::{self, xyzw};
use grasp_recognise::{Hypothesis, RecogniseError, Recognition, Side, Timings, Warning};
use grasp_robot::{ObservedHand, Setting, Strategy};

/// What the program says where it gives no class.
pub const UNKNOWN: &str = "unknown";

/// What is known about one input: an answer or an error.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Record {
    /// The input was recognised.
    Answer(Box<Answer>),
    /// The input has no answer.
    Failure(Failure),
}

/// As a schema it is not `oneOf`: an answer without the strategy that was asked for has an `error`,
/// and with it all that a [`Failure`] must have.
#[cfg(feature = "schema")]
mod schema {
    use std::borrow::Cow;

    use utoipa::openapi::schema::{AnyOfBuilder, Schema};
    use utoipa::openapi::{Ref, RefOr};
    use utoipa::{PartialSchema, ToSchema};

    use super::{Answer, Failure, Record};

    impl PartialSchema for Record {
        fn schema() -> RefOr<Schema> {
            let either = AnyOfBuilder::new()
                .item(Ref::from_schema_name(Answer::name()))
                .item(Ref::from_schema_name(Failure::name()));
            either
                .description(Some("What is known about one input: an answer, with `grasp`, or an error."))
                .into()
        }
    }

    impl ToSchema for Record {
        fn name() -> Cow<'static, str> {
            "Record".into()
        }

        fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
            schemas.push((Answer::name().into(), Answer::schema()));
            schemas.push((Failure::name().into(), Failure::schema()));
            Answer::schemas(schemas);
            Failure::schemas(schemas);
        }
    }
}

/// An input that was recognised.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Answer {
    /// The input as it was named; `-` for standard input.
    pub file: String,
    /// The frame's number in a stream, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// The most probable class, or `unknown`.
    pub grasp: String,
    /// Its number in Cutkosky's taxonomy; null where it is unknown.
    pub cutkosky: Option<u8>,
    /// Why it is unknown; null where it is not.
    pub reason: Option<String>,
    /// What should make a reader doubt the answer.
    pub warnings: Vec<WarningRecord>,
    /// The probability of the most probable class, 0..=1.
    pub probability: f64,
    /// All classes of the index, most probable first.
    pub classes: Vec<ClassRecord>,
    /// How far the grasp is closed; left out where the index's descriptor does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<StagesRecord>,
    /// The hand that was recognised.
    pub hand: Side,
    /// How far the picture was turned for that, in degrees clockwise.
    pub roll_deg: f64,
    /// How the hand is turned toward the camera.
    pub orientation: OrientationRecord,
    /// The nearest entries, nearest first.
    pub neighbours: Vec<NeighbourRecord>,
    /// What the search cost.
    pub search: SearchRecord,
    /// The robot's strategy; null unless one was asked for.
    pub strategy: Option<Strategy>,
    /// Why there is no strategy, where one was asked for; otherwise null.
    pub error: Option<ErrorRecord>,
    /// What this frame alone says, where the answer is that of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single: Option<SingleRecord>,
    /// Milliseconds of each step, where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timings: Option<Timings>,
}

impl Answer {
    /// Puts the robot's strategy into the answer, or why there is none. What is unknown is not
    /// imitated.
    pub fn imitate(&mut self, found: &Recognition, setting: &Setting) {
        if self.reason.is_some() {
            return;
        }
        let seen = ObservedHand {
            grasp: self.grasp.clone(),
            side: found.best.side,
            camera_from_hand: found.best.vote.orientation.rotation,
            spread_deg: found.best.vote.orientation.spread_deg,
        };
        match setting.strategy(&seen) {
            Ok(strategy) => self.strategy = Some(strategy),
            Err(error) => {
                let message = error.to_string();
                self.error = Some(ErrorRecord { kind: error.kind(), message, is_rejection: false });
            }
        }
    }
}

/// What one frame of a sequence says by itself.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct SingleRecord {
    /// The most probable class, or `unknown`.
    pub grasp: String,
    /// The probability of the most probable class, 0..=1.
    pub probability: f64,
    /// The rotation `camera_from_hand` as a unit quaternion x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
}

impl SingleRecord {
    /// Of a recognition before any other frame has been heard.
    pub fn new(found: &Recognition) -> Self {
        let vote = &found.best.vote;
        let first = vote.classes.first();
        Self {
            grasp: match first {
                Some(first) if found.doubt.is_none() => first.name.clone(),
                _ => UNKNOWN.to_owned(),
            },
            probability: first.map_or(0.0, |first| first.probability),
            quaternion_xyzw: xyzw(&vote.orientation.rotation),
        }
    }
}

/// An input that has no answer.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Failure {
    /// The input as it was named.
    pub file: String,
    /// The frame's number in a stream, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// Why.
    pub error: ErrorRecord,
}

/// Why an input has no answer.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ErrorRecord {
    /// A short, stable name.
    pub kind: &'static str,
    /// What happened and what to do.
    pub message: String,
    /// Whether the input is sound but shows no hand that can be recognised (exit status 1, not 2).
    #[serde(skip)]
    pub is_rejection: bool,
}

/// How probable each stage of a grasp is; all sum to 1.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct StagesRecord {
    /// The hand reaches for the object.
    pub reach: f64,
    /// It is about to grasp.
    pub close: f64,
    /// It grasps.
    pub grasp: f64,
}

impl From<[f64; 3]> for StagesRecord {
    fn from([reach, close, grasp]: [f64; 3]) -> Self {
        Self { reach, close, grasp }
    }
}

/// A reason to doubt an answer.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct WarningRecord {
    /// A short, stable name, such as `segmentation_doubtful`.
    pub kind: &'static str,
    /// What was seen and, where there is something, what to do.
    pub message: String,
}

impl WarningRecord {
    fn new(warning: &Warning) -> Self {
        Self { kind: warning.kind(), message: warning.to_string() }
    }
}

/// A class and its probability.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ClassRecord {
    /// The class's name.
    pub grasp: String,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// 0..=1; all classes sum to 1.
    pub probability: f64,
}

/// The rotation `camera_from_hand`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct OrientationRecord {
    /// As a unit quaternion x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
    /// As angles in degrees about the camera's fixed axes x, y, z, in that order.
    pub euler: [f64; 3],
    /// The same angles by name, with their order.
    pub euler_deg: EulerRecord,
    /// How far the neighbours disagree, in degrees.
    pub spread_deg: f64,
    /// Which side of the hand the camera sees.
    pub camera_sees: &'static str,
    /// Where the fingers point in the picture.
    pub fingers_point: &'static str,
}

impl OrientationRecord {
    fn new(best: &Hypothesis) -> Self {
        let turned = &best.vote.orientation;
        Self {
            quaternion_xyzw: xyzw(&turned.rotation),
            euler: turned.euler_deg,
            euler_deg: turned.euler_deg.into(),
            spread_deg: turned.spread_deg,
            camera_sees: orientation::side_seen(&turned.rotation, best.side),
            fingers_point: orientation::fingers_point(&turned.rotation),
        }
    }
}

/// A rotation as three angles in degrees.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct EulerRecord {
    /// About which axes the angles turn, and which comes first: always `extrinsic xyz`, about the
    /// camera's fixed x (right), then its y (down), then its z (forward).
    pub order: &'static str,
    /// About x.
    pub x: f64,
    /// About y.
    pub y: f64,
    /// About z.
    pub z: f64,
}

impl From<[f64; 3]> for EulerRecord {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { order: "extrinsic xyz", x, y, z }
    }
}

/// An entry of the index that is near to the input.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct NeighbourRecord {
    /// The entry's number in the index.
    pub id: u32,
    /// The file that the entry was made from.
    pub file: String,
    /// Its class.
    pub grasp: String,
    /// Its class's number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// Its hand shape.
    pub hand_shape: String,
    /// Its stage.
    pub stage: String,
    /// Its object.
    pub object: String,
    /// The distance between the descriptors.
    pub distance: f32,
    /// Its orientation, turned and flipped to the input as the answer is; `null` where the index
    /// keeps none.
    pub quaternion_xyzw: Option<[f64; 4]>,
}

impl NeighbourRecord {
    fn new(neighbour: &Neighbour, best: &Hypothesis, index: &Index) -> Result<Self, EntryError> {
        let entry = index.entry(neighbour.id)?;
        let class = entry.class.and_then(|class| index.catalogue().classes.get(usize::from(class)));
        Ok(Self {
            id: neighbour.id,
            file: entry.file.to_owned(),
            grasp: class.map(|class| class.name.clone()).unwrap_or_default(),
            cutkosky: class.map(|class| class.cutkosky).unwrap_or_default(),
            hand_shape: entry.hand_shape.to_owned(),
            stage: entry.stage.to_owned(),
            object: entry.object.to_owned(),
            distance: neighbour.distance,
            quaternion_xyzw: entry.orientation.map(|rotation| xyzw(&best.in_picture(&rotation))),
        })
    }
}

/// What a search cost.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct SearchRecord {
    /// Tables that were looked into.
    pub tables: u32,
    /// Buckets that were looked into.
    pub buckets: u32,
    /// Entries that were looked at: those in the buckets.
    pub candidates: u32,
    /// The same as a share of the index, 0..=1.
    pub share_of_database: f64,
    /// Whether every entry was measured.
    pub exact: bool,
    /// Candidates whose distance was measured by the original descriptors.
    pub reranked: u32,
    /// The share of the true 10 nearest that such a search found when the index was measured; null
    /// where that is unknown.
    pub predicted_recall: Option<f64>,
    /// How many such searches were compared: hands times rolls. The other numbers are those of the
    /// best one; the hand that it finds is then looked at from beside by two more, for a learned
    /// descriptor, which no number here counts.
    pub searches: usize,
}

impl SearchRecord {
    fn new(best: &Hypothesis) -> Self {
        Self {
            tables: best.cost.tables,
            buckets: best.cost.buckets,
            candidates: best.cost.candidates,
            share_of_database: best.cost.share_of_database,
            exact: best.cost.exact,
            reranked: best.cost.reranked,
            predicted_recall: best.cost.predicted_recall,
            searches: best.tried,
        }
    }
}

impl Record {
    /// The name of the input.
    pub fn file(&self) -> &str {
        match self {
            Self::Answer(answer) => &answer.file,
            Self::Failure(failure) => &failure.file,
        }
    }

    /// The record of an answer.
    ///
    /// # Errors
    /// Where an entry of the index cannot be read: the index is corrupt.
    pub fn answer(
        file: String,
        frame: Option<u64>,
        found: &Recognition,
        index: &Index,
        timings: bool,
    ) -> Result<Self, EntryError> {
        let best = &found.best;
        let classes: Vec<ClassRecord> = best
            .vote
            .classes
            .iter()
            .map(|class| ClassRecord {
                grasp: class.name.clone(),
                cutkosky: class.cutkosky,
                probability: class.probability,
            })
            .collect();
        let probability = classes.first().map_or(0.0, |class| class.probability);
        let (grasp, cutkosky) = match classes.first() {
            Some(first) if found.doubt.is_none() => (first.grasp.clone(), Some(first.cutkosky)),
            _ => (UNKNOWN.to_owned(), None),
        };
        let neighbours = best.neighbours.iter().map(|one| NeighbourRecord::new(one, best, index));
        Ok(Self::Answer(Box::new(Answer {
            file,
            frame,
            grasp,
            cutkosky,
            reason: found.doubt.map(|doubt| doubt.to_string()),
            warnings: found.warnings.iter().map(WarningRecord::new).collect(),
            probability,
            classes,
            stages: best.vote.stages.map(StagesRecord::from),
            hand: best.side,
            roll_deg: best.roll_deg,
            orientation: OrientationRecord::new(best),
            neighbours: neighbours.collect::<Result<_, EntryError>>()?,
            search: SearchRecord::new(best),
            strategy: None,
            error: None,
            single: None,
            timings: timings.then_some(found.timings),
        })))
    }

    /// The record of a picture that could not be recognised.
    pub fn not_recognised(file: String, frame: Option<u64>, error: &RecogniseError) -> Self {
        Self::Failure(Failure {
            file,
            frame,
            error: ErrorRecord {
                kind: error.kind(),
                message: error.to_string(),
                is_rejection: error.is_rejection(),
            },
        })
    }

    /// The record of an input that failed for another reason.
    pub fn failed(file: String, frame: Option<u64>, kind: &'static str, message: String) -> Self {
        Self::Failure(Failure { file, frame, error: ErrorRecord { kind, message, is_rejection: false } })
    }

    /// The exit status that the input asks for: 0 recognised, 1 rejected, unknown, or with a
    /// strategy that is not feasible, 2 an error.
    pub fn status(&self) -> u8 {
        match self {
            Self::Answer(answer) if answer.error.is_some() => 2,
            Self::Answer(answer) => {
                let is_infeasible = answer.strategy.as_ref().is_some_and(|strategy| !strategy.feasible);
                u8::from(answer.reason.is_some() || is_infeasible)
            }
            Self::Failure(failure) if failure.error.is_rejection => 1,
            Self::Failure(_) => 2,
        }
    }
}
