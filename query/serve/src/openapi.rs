//! The description of the interface, made from the code that answers.

use utoipa::openapi::OpenApi as Api;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa::{Modify, OpenApi};

use super::tags::{DESCRIPTORS, INDEX, OPERATION, PICTURES};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "grasp-query serve",
        description = "Which grasp a hand in a picture makes, and how it is turned toward the camera.\n\n\
            Every request that has no answer gets a status of 400 or more and a JSON body of the form \
            `{\"error\": {\"kind\": .., \"message\": ..}}`; the message says what to do next. 429 and 503 pass: the header \
            `Retry-After` says after how many seconds to try again.\n\n\
            Where the service was started with `--token-file`, every path but `/`, `/docs`, `/openapi.json`, `/healthz` and \
            `/readyz` needs the header `Authorization: Bearer TOKEN`. Requests that a page of another origin makes a browser send \
            are refused (403).",
        license(name = "MIT OR Apache-2.0")
    ),
    tags(
        (name = PICTURES, description = "Send a picture of a hand, get the grasp."),
        (name = DESCRIPTORS, description = "Send descriptors, get the nearest entries of the index."),
        (name = INDEX, description = "What is served."),
        (name = OPERATION, description = "For those who run the service.")
    ),
    paths(
        super::work::recognise_picture,
        super::work::robot_strategy,
        super::work::search_descriptors,
        super::about::index,
        super::about::thumbnail,
        super::guard::session,
        super::about::ready,
        super::about::health,
        super::about::metrics
    ),
    components(schemas(
        super::recognise::ExplainedRecord,
        grasp_recognise::HandChoice,
        crate::wire::parameters::AcceptChoice,
        crate::wire::parameters::SegmentBy
    )),
    modifiers(&Token)
)]
struct Description;

/// The token, where the service asks for one.
struct Token;

impl Modify for Token {
    fn modify(&self, api: &mut Api) {
        let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer);
        let scheme = scheme.description(Some(
            "The token of the service's --token-file; none is needed without that option.",
        ));
        let components = api.components.get_or_insert_default();
        components.add_security_scheme("token", SecurityScheme::Http(scheme.build()));
    }
}

/// The description as JSON.
pub(super) fn json() -> String {
    Description::openapi().to_json().unwrap_or_default()
}
