//! Requests that have no answer, told as JSON in the form of a record's own `error`.

use std::time::Duration;

use crate::wire::ParameterError;
use axum::Json;
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::shown::shown;
use grasp_answer::record::ErrorRecord;

/// Seconds after which one who was turned away may come back.
const RETRY_AFTER: HeaderValue = HeaderValue::from_static("1");

/// Why a request has no answer.
#[derive(Debug)]
pub struct Problem {
    pub(super) status: StatusCode,
    kind: &'static str,
    message: String,
}

/// What is sent of it.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ProblemRecord {
    error: ErrorRecord,
}

impl Problem {
    /// A problem with a status; `kind` is a short, stable name.
    pub fn new(status: StatusCode, kind: &'static str, message: impl Into<String>) -> Self {
        Self { status, kind, message: message.into() }
    }

    #[cfg(test)]
    pub(super) fn message(&self) -> &str {
        &self.message
    }

    /// The request is malformed.
    pub fn bad_request(message: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "request", message)
    }

    /// Nothing lies at the path.
    pub fn missing(message: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not_found", message)
    }

    /// The router adds the header `Allow`, which names the methods that are taken.
    pub async fn method_not_allowed(method: Method) -> Self {
        let message =
            format!("{} is not what this path takes: the header Allow says what is", shown(method.as_str()));
        Self::new(StatusCode::METHOD_NOT_ALLOWED, "method", message)
    }

    pub(super) fn busy() -> Self {
        Self::new(
            StatusCode::TOO_MANY_REQUESTS,
            "busy",
            "as many requests are waiting as the service holds: try again a little later",
        )
    }

    pub(super) fn not_ready(why: &str) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "not_ready", format!("the service {why}: try again later"))
    }

    /// The request has not come within `time`.
    pub fn late(time: Duration) -> Self {
        let seconds = time.as_secs_f64();
        let message = format!(
            "the request did not arrive within {seconds} s, as it has to: send it faster, or less of it"
        );
        Self::new(StatusCode::REQUEST_TIMEOUT, "timeout", message)
    }

    /// Less than `least` bytes of the request have come within `time`.
    pub(super) fn stalled(least: usize, time: Duration) -> Self {
        let seconds = time.as_secs_f64();
        let message = format!(
            "the request stopped coming: at least {least} bytes of it have to come in each {seconds} s, or its end; send it \
             again, without a pause"
        );
        Self::new(StatusCode::REQUEST_TIMEOUT, "timeout", message)
    }

    pub(super) fn too_slow() -> Self {
        Self::new(
            StatusCode::SERVICE_UNAVAILABLE,
            "timeout",
            "no answer was found in the time that a request may take: try again, or ask for less",
        )
    }

    pub(super) fn lost() -> Self {
        Self::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "internal",
            "the request could not be worked on, which is a fault of this program: please report it with what was sent",
        )
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let Self { status, kind, message } = self;
        let record = ProblemRecord { error: ErrorRecord { kind, message, is_rejection: false } };
        let mut response = (status, Json(record)).into_response();
        let headers = response.headers_mut();
        if matches!(status, StatusCode::TOO_MANY_REQUESTS | StatusCode::SERVICE_UNAVAILABLE) {
            headers.insert(header::RETRY_AFTER, RETRY_AFTER);
        }
        if status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        response
    }
}
impl From<ParameterError> for Problem {
    fn from(error: ParameterError) -> Self {
        Self::bad_request(error.to_string())
    }
}
