//! What can be wrong with the description of a hand, an arm, an object or a camera.

mod urdf;

use thiserror::Error;

pub use urdf::UrdfFault;

/// What is wrong with a description, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DescriptionFault {
    /// It is no TOML, or has other keys than such a description.
    #[error("{}", toml_message(.0))]
    Toml(toml::de::Error),
    /// No description is so long.
    #[error("{kib} KiB: descriptions of at most {most} KiB are read")]
    Long {
        /// Its length.
        kib: usize,
        /// The longest.
        most: usize,
    },
    /// Four numbers that are no rotation.
    #[error("{key} has the length {length:.4}: a rotation needs 1, in the order x, y, z, w")]
    Rotation {
        /// The key.
        key: &'static str,
        /// Their length.
        length: f64,
    },
    /// A place beyond all that this program is for.
    #[error("{key} = {position:?}: each must be within {most} m")]
    Position {
        /// The key.
        key: &'static str,
        /// What it says, in metres.
        position: [f64; 3],
        /// How far from 0 each may be, in metres.
        most: f64,
    },
    /// A length, or another measure, that is not positive or too large.
    #[error("{key} = {value}: it must be above 0 and at most {most}")]
    Measure {
        /// The key.
        key: String,
        /// What it says.
        value: f64,
        /// The most, in the same unit.
        most: f64,
    },
    /// A dimension of an arm that no arm has.
    #[error("{key} = {metres}: it must be within {most} m")]
    Dimension {
        /// The key.
        key: &'static str,
        /// What it says.
        metres: f64,
        /// How far from 0 it may be, in metres.
        most: f64,
    },
    /// A zero angle beyond a whole turn.
    #[error("offsets hold {0}: each must be within a turn, in radians")]
    Offset(f64),
    /// A sign that is neither 1 nor -1.
    #[error("signs = {0:?}: each must be 1 or -1")]
    Signs([i8; 6]),
    /// How far an arm's joint turns.
    #[error(
        "limits of {joint} = [{low}, {high}]: each must be within two turns, in radians, and the lower one first"
    )]
    Limits {
        /// The joint.
        joint: String,
        /// In radians.
        low: f64,
        /// See `low`.
        high: f64,
    },
    /// How far a hand's joint moves.
    #[error(
        "limits.{joint} = {ends:?}: two numbers within {most:.2} rad (metres where it slides), the lower one first"
    )]
    Range {
        /// The joint.
        joint: String,
        /// In radians, or metres where it slides.
        ends: [f64; 2],
        /// How far from 0 each may be.
        most: f64,
    },
    /// An arm that would take too long to move.
    #[error(
        "there are {joints} joints and {segments} segments: an arm has at most {most_joints} and {most_segments}"
    )]
    ArmSize {
        /// How many joints.
        joints: usize,
        /// The most.
        most_joints: usize,
        /// How many segments.
        segments: usize,
        /// The most.
        most_segments: usize,
    },
    /// An arm with more joints than limits, or fewer.
    #[error("there are {joints} joints and {limits} limits: each needs its own")]
    JointCount {
        /// How many joints.
        joints: usize,
        /// How many limits.
        limits: usize,
    },
    /// An arm with a spherical wrist and another number of joints.
    #[error("an arm with [geometry] has six joints")]
    SixJoints,
    /// An arm that is described in no way, or in two.
    #[error(
        "an arm needs either [geometry], where its last three axes meet in a point, or its joints one by one as [[segment]]"
    )]
    NoJoints,
    /// A joint of an arm that moves no part of it, or several.
    #[error("`{joint}` of `joints` must move one [[segment]], and moves {count}")]
    SegmentsOfJoint {
        /// The joint.
        joint: String,
        /// How many it moves.
        count: usize,
    },
    /// A part of an arm that is moved by a joint which the arm does not have.
    #[error("`{0}` moves a [[segment]] and is not among `joints`")]
    StrayJoint(String),
    /// A part of a finger or an arm of impossible size.
    #[error(
        "a segment at {at:?}: metres within {longest}, radians within a turn, and a factor and plus within 100 are needed"
    )]
    Segment {
        /// Where it begins, in metres.
        at: [f64; 3],
        /// The most, in metres.
        longest: f64,
    },
    /// An axis of no length.
    #[error("a segment's axis {0:?} has no direction")]
    SegmentAxis([f64; 3]),
    /// A finger without parts.
    #[error("chain: a finger needs segments")]
    NoSegments,
    /// A part of a finger that is moved by a joint which the hand does not have.
    #[error("chain: `{0}` is no joint of [limits]")]
    ChainJoint(String),
    /// A gripper's URDF, or what stands beside it.
    #[error(transparent)]
    Urdf(#[from] UrdfFault),
    /// A finger is moved by a joint that the hand does not have.
    #[error("finger: `{0}` is no joint of [limits]")]
    FingerJoint(String),
    /// Which way a finger spreads.
    #[error("finger.spread.sign: 1 or -1 is needed")]
    FingerSign,
    /// A finger of impossible size, or bent by impossible angles.
    #[error("finger: metres within {longest} and radians within a turn are needed")]
    Finger {
        /// The longest part of a finger, in metres.
        longest: f64,
    },
    /// A human grasp that is none of the six.
    #[error("{table}.{human}: the human grasps are {known}")]
    HumanGrasp {
        /// The table that names it.
        table: &'static str,
        /// What the key says.
        human: String,
        /// Those that there are.
        known: String,
    },
    /// A human grasp's counterpart that the hand does not have.
    #[error("map.{human} = `{robot}`, which is not one of its grasps: they are {known}")]
    NoSuchGrasp {
        /// The human grasp.
        human: String,
        /// What it is mapped to.
        robot: String,
        /// Those that there are.
        known: String,
    },
    /// Distances of a grasp that cannot be used.
    #[error(
        "grasp.{0}: standoff, middle, table_clearance and table_reach need metres, points with ascending widths"
    )]
    Distances(String),
    /// A posture that leaves joints out, or has others.
    #[error("grasp.{grasp}.{posture} must name every joint of [limits], and no other")]
    Posture {
        /// The grasp.
        grasp: String,
        /// `open` or `closed`.
        posture: &'static str,
    },
    /// A joint beyond its limits.
    #[error(
        "grasp.{grasp}.{posture}.{joint}: values must lie from {least} to {most}, and the widths of points must ascend"
    )]
    Joint {
        /// The grasp.
        grasp: String,
        /// `open` or `closed`.
        posture: &'static str,
        /// The joint.
        joint: String,
        /// Its limits, in radians, or metres where it slides.
        least: f64,
        /// See `least`.
        most: f64,
    },
    /// A hand where the camera does not look.
    #[error(
        "hand is at z = {ahead} m in the camera's frame, behind it, where no picture shows it: its z points forward, its x right \
         and its y down in the picture"
    )]
    HandBehind {
        /// How far the wrist is before the camera, in metres.
        ahead: f64,
    },
    /// A shape that is none.
    #[error("shape = `{0}`: it must be cylinder, disc, box or sphere")]
    Shape(String),
    /// A shape without one of its measures.
    #[error("a {shape} needs `{key}`, in metres")]
    MissingMeasure {
        /// The shape.
        shape: String,
        /// The key.
        key: &'static str,
    },
    /// A shape with a measure that it does not have.
    #[error("a {shape} has no `{key}`: leave it out, or name the shape that has it")]
    NeedlessMeasure {
        /// The shape.
        shape: String,
        /// The key.
        key: &'static str,
    },
    /// A box without its three.
    #[error("a box has no size without `size = [x, y, z]`, in metres")]
    MissingSize,
    /// An object that is partly inside its table.
    #[error(
        "it lies {:.0} mm inside the table: raise its position, which is that of its middle, or lower `table`",
        1e3 * metres
    )]
    InTable {
        /// How deep.
        metres: f64,
    },
}

/// What a reader of TOML says, with the line that it shows, unless that is longer than anybody
/// reads.
fn toml_message(error: &toml::de::Error) -> String {
    const LONGEST_LINE: usize = 200;
    let whole = error.to_string();
    match whole.lines().all(|line| line.len() <= LONGEST_LINE) {
        true => whole.trim_end().to_owned(),
        false => error.message().chars().take(LONGEST_LINE).collect(),
    }
}
