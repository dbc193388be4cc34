//! What can be wrong with the robot's files, or keep it from a strategy.

use std::path::PathBuf;

use super::fault::DescriptionFault;

/// Why there is no strategy.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// A file cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why; part of the message, and so no source beside it.
        cause: std::io::Error,
    },
    /// A file is no such description.
    #[error("{name} is not a valid description of {what}: {fault}")]
    Format {
        /// The file, or the name of a description that comes with the program.
        name: String,
        /// What it should describe, with its article.
        what: &'static str,
        /// What is wrong and what is needed; part of the message, and so no source beside it.
        fault: Box<DescriptionFault>,
    },
    /// The hand is none that comes with the program.
    #[error("there is no robot hand `{name}`: use {known}, or name a file that describes one (HAND.toml)")]
    UnknownHand {
        /// What was asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The arm is none that comes with the program.
    #[error("there is no arm `{name}`: use {known}, or name a file that describes one (ARM.toml)")]
    UnknownArm {
        /// What was asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The human grasp has no counterpart.
    #[error("{hand} has no grasp for `{grasp}`: name one under [map] of its description")]
    Unmapped {
        /// The robot hand.
        hand: String,
        /// The human grasp.
        grasp: String,
    },
    /// The human grasp is none of the six.
    #[error("the human approach is known for the six grasps only, and `{grasp}` is not one of them")]
    UnknownHuman {
        /// The human grasp.
        grasp: String,
    },
    /// The hand has no such grasp.
    #[error("{hand} has no grasp `{grasp}`: it has {known}")]
    UnknownGrasp {
        /// The robot hand.
        hand: String,
        /// The robot grasp that was asked for.
        grasp: String,
        /// Those that there are.
        known: String,
    },
    /// The hand cannot be simulated.
    #[error("{hand} has no model to simulate: take barrett, or a file with `model = \"barrett\"`")]
    NoModel {
        /// The robot hand.
        hand: String,
    },
    /// The hand has not all joints of the model that simulates it.
    #[error("{hand} has no joint {joint}, which the model that simulates it moves")]
    NoJoint {
        /// The robot hand.
        hand: String,
        /// The joint.
        joint: &'static str,
    },
    /// The object is where the camera does not look.
    #[error(
        "{object} is at z = {ahead:.3} m in the camera's frame, behind it, where no picture shows it: check position and \
         quaternion_xyzw of camera and object; the camera's z points forward, its x right and its y down in the picture"
    )]
    BehindCamera {
        /// The object.
        object: String,
        /// How far its middle is before the camera, in metres.
        ahead: f64,
    },
    /// The object does not go between the fingers.
    #[error(
        "{object} is {:.0} mm wide where the fingers close, and {hand} opens to {:.0} mm: {}",
        1e3 * width, 1e3 * widest, nearest(*turned, others)
    )]
    TooWide {
        /// The object.
        object: String,
        /// The robot hand.
        hand: String,
        /// The object's extent, in metres.
        width: f64,
        /// The most, in metres.
        widest: f64,
        /// Its extent for a hand that is turned by a quarter about the approach, in metres, where
        /// the hand could take that.
        turned: Option<f64>,
        /// Hands that come with the program and could take it.
        others: Vec<&'static str>,
    },
    /// A URDF has no file beside it that says what a URDF does not.
    #[error(
        "a URDF says neither where the palm of a hand is nor what its fingers' tips are: write {}, which does, for example\n{example}",
        companion.display()
    )]
    NoCompanion {
        /// The file that is missing.
        companion: PathBuf,
        /// What could stand in it.
        example: String,
    },
    /// The object to simulate lies nowhere.
    #[error("{object} has no `table`, or its pose is not in the world: a trial needs both to begin with")]
    NoTable {
        /// The object.
        object: String,
    },
    /// The orientation of the human hand is unknown.
    #[error("the neighbours have no orientations: use an index that was built with them")]
    NoOrientation,
}

/// What comes nearest to what cannot be done.
fn nearest(turned: Option<f64>, others: &[&str]) -> String {
    let side = turned.map_or_else(
        || "approach it from another side".to_owned(),
        |width| {
            format!(
                "turned by a quarter about the approach the hand would find it {:.0} mm wide; approach it so",
                1e3 * width
            )
        },
    );
    match others {
        [] => side,
        others => format!("{side}, or take a hand that opens wider ({})", others.join(", ")),
    }
}

impl RobotError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Read { .. } | Self::Format { .. } | Self::NoCompanion { .. } => "file",
            Self::UnknownHand { .. } => "unknown_hand",
            Self::UnknownArm { .. } => "unknown_arm",
            Self::Unmapped { .. } => "unmapped",
            Self::UnknownHuman { .. } => "unknown_human",
            Self::UnknownGrasp { .. } => "unknown_grasp",
            Self::NoModel { .. } | Self::NoJoint { .. } => "no_model",
            Self::NoTable { .. } => "no_table",
            Self::BehindCamera { .. } => "behind_camera",
            Self::TooWide { .. } => "too_wide",
            Self::NoOrientation => "no_orientation",
        }
    }
}
