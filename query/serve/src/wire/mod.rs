//! What crosses the line between the service and its clients: the options of a request, the formats
//! of an answer, the token, and the names of headers and of parts.

mod accept;
mod format;
mod parameter_error;
pub mod parameters;
mod token;

use axum::http::HeaderName;

pub(crate) use accept::wanted;
pub use format::Format;
pub use parameter_error::ParameterError;
pub use token::Token;

/// The header of the exit status that the command line would have had: 0 recognised, 1 rejected, 2
/// an error.
pub(crate) const STATUS: HeaderName = HeaderName::from_static("grasp-status");
/// The header that says which index answered, counted from 1.
pub(crate) const GENERATION: HeaderName = HeaderName::from_static("grasp-index-generation");
/// The most neighbours that one request for raw neighbours is answered with, candidates included:
/// some 10 MB of JSON.
pub const MOST_NEIGHBOURS: usize = 100_000;
/// What `robot` and `arm` say where a part of the form describes them.
pub const DESCRIBED: &str = "described";
