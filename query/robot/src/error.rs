//! What can be wrong with the robot's files, or keep it from a strategy.

use std::path::PathBuf;

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
    #[error("{name} is not a valid description of {what}: {problem}")]
    Format {
        /// The file, or the name of a description that comes with the program.
        name: String,
        /// What it should describe, with its article.
        what: &'static str,
        /// What is wrong and what is needed.
        problem: String,
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
    #[error("{hand} has no grasp for `{grasp}`: name one under [map] in its file")]
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
    /// The object does not go between the fingers.
    #[error(
        "{object} is {:.0} mm wide where the fingers close, and {hand} opens to {:.0} mm: approach it from another side, or take another hand",
        1e3 * width, 1e3 * widest
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

impl RobotError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Read { .. } | Self::Format { .. } => "file",
            Self::UnknownHand { .. } => "unknown_hand",
            Self::UnknownArm { .. } => "unknown_arm",
            Self::Unmapped { .. } => "unmapped",
            Self::UnknownHuman { .. } => "unknown_human",
            Self::UnknownGrasp { .. } => "unknown_grasp",
            Self::NoModel { .. } => "no_model",
            Self::NoTable { .. } => "no_table",
            Self::TooWide { .. } => "too_wide",
            Self::NoOrientation => "no_orientation",
        }
    }
}
