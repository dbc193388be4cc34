//! Why a file is no hand.

use std::io;

use super::fault::{ModelFault, NotAHand, Unsupported};

/// Longest file that is read, in bytes.
pub(super) const LONGEST: u64 = 256 << 20;
/// Why a file cannot be used as a hand.
#[derive(Debug, thiserror::Error)]
pub enum HandModelError {
    /// The file cannot be read.
    #[error("it cannot be read")]
    Read(#[from] io::Error),
    /// The file's name cannot be the hand's.
    #[error(
        "a hand cannot be named `{0}`: rename the file, using up to 64 of a-z, A-Z, 0-9, - and _, and not the name of a built-in hand"
    )]
    Name(String),
    /// The file is larger than any hand.
    #[error("it is larger than {} MB: reduce the mesh and leave out its textures", LONGEST / 1_000_000)]
    TooLarge,
    /// Some other file.
    #[error("it is not a binary glTF file: export the hand as .glb")]
    NotGlb,
    /// The document inside is damaged.
    #[error("its description is damaged: {0}")]
    Json(#[from] serde_json::Error),
    /// The file contradicts itself or the format.
    #[error("it is damaged: {0}")]
    Broken(ModelFault),
    /// Something that glTF allows and that is not read here.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// Joints that every hand has are not there.
    #[error("it lacks {} of the 25 joints of WebXR's hands: {}; name the bones like these", .0.len(), .0.join(", "))]
    MissingJoints(Vec<&'static str>),
    /// Two joints have one name.
    #[error("the joint {0} is there more than once: one hand a file")]
    TwiceJoint(&'static str),
    /// It is all there, but it is no human hand.
    #[error(transparent)]
    NotAHand(#[from] NotAHand),
}

// The fault is part of the message, and so no source beside it.
impl From<ModelFault> for HandModelError {
    fn from(fault: ModelFault) -> Self {
        Self::Broken(fault)
    }
}
