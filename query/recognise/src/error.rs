//! Why a picture has no answer.

use grasp_index::{HandImageError, SearchError};

#[cfg(feature = "landmarks")]
use crate::mediapipe::HandNetworksError;
use crate::picture::DecodeError;
use crate::scene::LandmarksError;
use crate::segment::MaskError;

/// Why a mask, or what stands for one, cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// It belongs to another picture.
    #[error(transparent)]
    Mask(#[from] MaskError),
    /// So does a depth picture.
    #[error(
        "the depth picture has {} x {} pixels, its picture {} x {}: they must agree",
        depth[0], depth[1], picture[0], picture[1]
    )]
    Depth {
        /// The depth picture's pixels in a row, and its rows.
        depth: [usize; 2],
        /// The picture's.
        picture: [usize; 2],
    },
    /// So do landmarks.
    #[error(transparent)]
    Landmarks(#[from] LandmarksError),
    /// The networks that find them cannot be run.
    #[cfg(feature = "landmarks")]
    #[error(transparent)]
    Networks(#[from] HandNetworksError),
}

/// Why a picture has no answer.
#[derive(Debug, thiserror::Error)]
pub enum RecogniseError {
    /// The bytes are no picture.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The mask or the depth picture does not fit.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Nothing in the picture looks like a hand.
    #[error("no hand found: nothing in the picture looks like one (a mask can be given)")]
    NoHand,
    /// What says where the hand is, says that there is none.
    #[error("no hand: {0}")]
    Empty(&'static str),
    /// The hand is too small or its buffers do not fit.
    #[error(transparent)]
    Hand(HandImageError),
    /// The descriptor does not fit the index.
    #[error(transparent)]
    Search(#[from] SearchError),
}

impl RecogniseError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Decode(error) => error.kind(),
            Self::Source(SourceError::Mask(_)) => "mask",
            Self::Source(SourceError::Depth { .. }) => "depth",
            Self::Source(SourceError::Landmarks(_)) => "landmarks",
            #[cfg(feature = "landmarks")]
            Self::Source(SourceError::Networks(_)) => "landmarks",
            Self::NoHand | Self::Empty(_) => "no_hand",
            Self::Hand(_) => "hand_too_small",
            Self::Search(_) => "search",
        }
    }

    /// Whether the picture is sound and merely shows no hand that can be recognised.
    pub fn is_rejection(&self) -> bool {
        matches!(self, Self::NoHand | Self::Empty(_) | Self::Hand(_))
    }
}

impl From<HandImageError> for RecogniseError {
    fn from(error: HandImageError) -> Self {
        match error {
            HandImageError::NoHand { .. } => Self::NoHand,
            other => Self::Hand(other),
        }
    }
}
