//! What a request may be answered in place of what it asks for, as the description of the interface
//! lists it.

use std::collections::BTreeMap;

use axum::http::StatusCode;
use utoipa::openapi::response::Response;
use utoipa::openapi::{ContentBuilder, Ref, RefOr, ResponseBuilder};
use utoipa::{IntoResponses, ToSchema as _};

use super::problem::ProblemRecord;

/// Of every path, whatever it does.
const NAMED: (StatusCode, &str) =
    (StatusCode::FORBIDDEN, "The service is asked under a name that is not its own (`host`)");
/// Of paths that `guard` lets in by token and origin.
const GUARDED: [(StatusCode, &str); 2] = [
    (StatusCode::UNAUTHORIZED, "A token is needed, or another one than was shown"),
    (
        StatusCode::FORBIDDEN,
        "A page of another origin asks (`origin`), or one that asks under a name that is not the service's own (`host`)",
    ),
];
/// Of paths that also read a body and work on it.
const WORKED: [(StatusCode, &str); 5] = [
    (StatusCode::REQUEST_TIMEOUT, "The body came too slowly"),
    (StatusCode::PAYLOAD_TOO_LARGE, "Too many bytes, pixels or neighbours"),
    (
        StatusCode::TOO_MANY_REQUESTS,
        "Too many requests wait, or too many bytes; `Retry-After` says when to try again",
    ),
    (StatusCode::INTERNAL_SERVER_ERROR, "A fault of the program or of its index"),
    (StatusCode::SERVICE_UNAVAILABLE, "Not ready, or too slow; `Retry-After` says when to try again"),
];

/// What a path that anybody may ask for can refuse.
#[derive(Debug)]
pub(super) struct Named;

/// What a path that needs the token can refuse.
#[derive(Debug)]
pub(super) struct Guarded;

/// What a path that works on a body can refuse besides what is wrong with that.
#[derive(Debug)]
pub(super) struct Worked;

impl IntoResponses for Named {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        described([NAMED])
    }
}

impl IntoResponses for Guarded {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        described(GUARDED)
    }
}

impl IntoResponses for Worked {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        described(GUARDED.into_iter().chain(WORKED))
    }
}

fn described(
    refusals: impl IntoIterator<Item = (StatusCode, &'static str)>,
) -> BTreeMap<String, RefOr<Response>> {
    let response = |(status, description): (StatusCode, &str)| {
        let problem = Ref::from_schema_name(ProblemRecord::name());
        let content = ContentBuilder::new().schema(Some(problem)).build();
        let response = ResponseBuilder::new().description(description).content("application/json", content);
        (status.as_str().to_owned(), response.build().into())
    };
    refusals.into_iter().map(response).collect()
}
