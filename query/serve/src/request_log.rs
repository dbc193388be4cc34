//! What the log says of a request.

use std::time::{Duration, Instant};

use axum::extract::Request;
use axum::http::Method;

/// The most characters of a request's path and of its number that are logged.
const MOST_LOGGED: usize = 200;

/// A request, as it is logged when it is answered.
#[derive(Debug)]
pub(super) struct RequestLog {
    /// When it came.
    pub(super) at: Instant,
    method: Method,
    /// Without the query, which may say what nobody else should read.
    path: String,
    /// What the asker, or a proxy before the service, calls the request: its `X-Request-Id`.
    id: Option<String>,
}

impl RequestLog {
    pub(super) fn of(request: &Request) -> Self {
        let short = |text: &str| text.chars().take(MOST_LOGGED).collect();
        let id = request.headers().get("x-request-id").and_then(|id| id.to_str().ok());
        Self {
            at: Instant::now(),
            method: request.method().clone(),
            path: short(request.uri().path()),
            id: id.map(short),
        }
    }

    pub(super) fn log(&self, status: u16, took: Duration) {
        let Self { method, path, id, .. } = self;
        let (ms, request_id) = (took.as_secs_f64() * 1e3, id.as_deref());
        tracing::debug!(%method, path, status, ms, request_id, "{method} {path}: {status} in {ms:.1} ms");
    }
}
