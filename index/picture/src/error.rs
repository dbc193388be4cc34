//! Why bytes are no picture, and what is odd about a picture that was decoded all the same.

use std::path::PathBuf;

use crate::limits::{FORMATS, MAX_PIXELS, MAX_SCANS, MAX_SIDE};

/// Why bytes are no picture that can be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// There are no bytes at all.
    #[error("the file is empty; a picture is needed: {FORMATS}")]
    Empty,
    /// The first bytes belong to no picture format.
    #[error("not a picture: its first bytes are those of none of {FORMATS}")]
    NotAnImage,
    /// It is a picture of a format, or of a variety of one, that is not read.
    #[error("{what} is not read; convert it to one of {FORMATS}")]
    Unsupported {
        /// The format, with its article.
        what: &'static str,
    },
    /// The header asks for more pixels than are allowed; nothing was decoded.
    #[error(
        "the header says {width} x {height} pixels; at most {} megapixels and {MAX_SIDE} pixels a side are read: \
         shrink the picture first",
        MAX_PIXELS / 1_000_000
    )]
    TooLarge {
        /// Pixels in a row, as the header says.
        width: u32,
        /// Rows, as the header says.
        height: u32,
    },
    /// The file has more bytes than a picture of its size can need; nothing was decoded.
    #[error(
        "more than {} MB for {width} x {height} pixels, which no picture of that size needs: save it again without \
         what is embedded in it",
        most / 1_000_000
    )]
    TooLong {
        /// The most bytes that a picture of this size may have.
        most: u64,
        /// Pixels in a row, as the header says.
        width: u32,
        /// Rows, as the header says.
        height: u32,
    },
    /// The JPEG goes over its pixels too often; nothing was decoded.
    #[error("the JPEG has more than {MAX_SCANS} scans, where encoders write at most 11: save it again")]
    TooManyScans,
    /// The JPEG's tables are far longer than its scans can use; nothing was decoded.
    #[error("the JPEG has more tables than its scans can use: save it again")]
    TooManyTables,
    /// The picture ends before its last pixel.
    #[error("truncated image: the file ends before the last pixel; copy it again")]
    Truncated,
    /// The picture is damaged or of a variety that is not read.
    #[error("damaged or unsupported image: {0}")]
    Damaged(String),
}

impl DecodeError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Read { .. } => "unreadable",
            Self::Empty | Self::NotAnImage => "not_an_image",
            Self::Unsupported { .. } => "unsupported_format",
            Self::TooLarge { .. } | Self::TooLong { .. } | Self::TooManyScans | Self::TooManyTables => {
                "too_large"
            }
            Self::Truncated => "truncated",
            Self::Damaged(_) => "damaged",
        }
    }
}

/// What is odd about a picture that was decoded all the same.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeWarning {
    /// A JPEG without its end marker; the rows that its data does not reach are grey.
    #[error(
        "the JPEG has no end marker: it may be cut short, and {missing_percent} % of its rows are missing"
    )]
    NoEndMarker {
        /// The share of rows that were not decoded, rounded up, 0..=100.
        missing_percent: u32,
    },
    /// Bytes before this frame of a stream that belong to no picture.
    #[error("{bytes} bytes before this frame are no picture and were skipped")]
    Skipped {
        /// How many.
        bytes: u64,
    },
}

impl DecodeWarning {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::NoEndMarker { .. } => "no_end_marker",
            Self::Skipped { .. } => "bytes_skipped",
        }
    }
}
