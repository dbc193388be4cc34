//! The description of the interface, made from the code that answers.

use utoipa::OpenApi;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "grasp-query serve",
        description = "Which grasp a hand in a picture makes, and how it is turned toward the camera.",
        license(name = "MIT OR Apache-2.0")
    ),
    paths(
        super::recognise_picture,
        super::robot_strategy,
        super::search_descriptors,
        super::about::index,
        super::about::thumbnail,
        super::about::ready,
        super::about::health,
        super::about::metrics
    ),
    components(schemas(
        super::recognise::ExplainedRecord,
        crate::recognise::HandChoice,
        super::parameters::AcceptChoice
    ))
)]
struct Description;

/// The description as JSON.
pub(super) fn json() -> String {
    Description::openapi().to_json().unwrap_or_default()
}
