//! Small bodies of JSON, as pages send them.

use std::time::Duration;

use axum::extract::Request;
use axum::http::{StatusCode, header};
use http_body_util::{BodyExt as _, LengthLimitError, Limited};
use serde::de::DeserializeOwned;

use super::problem::Problem;

/// The most bytes of such a body.
const MOST: usize = 1024;
/// How long it may take to arrive.
const TIME: Duration = Duration::from_secs(5);

/// Reads a body of JSON; `form` shows what it looks like.
pub async fn json<T: DeserializeOwned>(request: Request, form: &str) -> Result<T, Problem> {
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let kind = kind.and_then(|kind| kind.split(';').next()).unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        let message = "the body must be JSON: send it with the header `Content-Type: application/json`";
        return Err(Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "request", message));
    }
    let body = tokio::time::timeout(TIME, Limited::new(request.into_body(), MOST).collect());
    let body = body.await.map_err(|_| Problem::late(TIME))?.map_err(|error| {
        if error.is::<LengthLimitError>() {
            let message = format!("more than {MOST} bytes: {form} is needed");
            Problem::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", message)
        } else {
            Problem::bad_request("the body breaks off: send it again")
        }
    })?;
    serde_json::from_slice(&body.to_bytes())
        .map_err(|_| Problem::bad_request(format!("the body is not what is needed: {form}")))
}
