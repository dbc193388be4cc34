//! A parameter of a request that cannot be.

use grasp_recognise::segment::depth::DepthRangeError;
use thiserror::Error;

/// What is wrong with a request's parameters: a message for the one who asked.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// Parameters that exclude each other.
    #[error("only one of {0} can be given")]
    OneOf(&'static str),
    /// A count that is too small or too large.
    #[error("{name} is {value}: an integer from {least} to {most} is needed")]
    Count {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: usize,
        /// The least that would do.
        least: usize,
        /// The most.
        most: usize,
    },
    /// A number that is not above 0.
    #[error("{name} is {value}: a number above 0 is needed")]
    Positive {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A number that is no share.
    #[error("{name} is {value}: a number above 0 and at most 1 is needed")]
    Share {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// An eps below 0.
    #[error("eps is {0}: a number of at least 0 is needed")]
    Eps(f64),
    /// A success without what shall succeed.
    #[error("success needs eps")]
    SuccessWithoutEps,
    /// No probes.
    #[error("probes is 0: an integer from 1 to {} is needed", u32::MAX)]
    Probes,
    /// Depths that are none.
    #[error("depth_range: {0}")]
    DepthRange(#[from] DepthRangeError),
}
