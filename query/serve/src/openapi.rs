//! The description of the interface, made from the code that answers.

use std::sync::LazyLock;

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
        grasp_answer::found::ShortlistRecord<'_>
    )),
    // Without --token-file none is needed; paths that anybody may ask for say so themselves.
    security((), ("token" = [])),
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
pub(super) static JSON: LazyLock<String> =
    LazyLock::new(|| Description::openapi().to_json().unwrap_or_default());

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn api() -> Value {
        serde_json::from_str(&JSON).unwrap()
    }

    /// Path and description of each operation.
    fn operations(api: &Value) -> Vec<(&str, &Value)> {
        let paths = api["paths"].as_object().unwrap().iter();
        paths.flat_map(|(path, of)| of.as_object().unwrap().values().map(|of| (path.as_str(), of))).collect()
    }

    fn keys(of: &Value) -> Vec<&str> {
        of.as_object().map(|of| of.keys().map(String::as_str).collect()).unwrap_or_default()
    }

    #[test]
    fn the_token_is_needed_where_it_is_asked_for() {
        let api = api();
        assert_eq!(api["security"], serde_json::json!([{}, {"token": []}]));
        assert!(api["components"]["securitySchemes"]["token"].is_object());
        for (path, of) in operations(&api) {
            let is_open = matches!(path, "/healthz" | "/readyz");
            assert_eq!(of["security"].is_array(), is_open, "{path}");
            assert_eq!(of["responses"]["401"].is_null(), is_open, "{path}");
            assert!(of["responses"]["403"].is_object(), "{path}");
        }
    }

    #[test]
    fn what_a_request_may_be_answered_is_listed() {
        let api = api();
        let statuses = |path: &str| keys(&api["paths"][path]["post"]["responses"]);
        let of_pictures =
            ["200", "400", "401", "403", "406", "408", "409", "413", "422", "429", "500", "503"];
        assert_eq!(statuses("/v1/recognise"), of_pictures);
        assert_eq!(statuses("/v1/strategy"), of_pictures);
        assert_eq!(statuses("/v1/search"), ["200", "400", "401", "403", "408", "413", "429", "500", "503"]);
        for path in ["/v1/recognise", "/v1/strategy"] {
            let mut kinds = keys(&api["paths"][path]["post"]["responses"]["200"]["content"]);
            let mut known = crate::wire::Format::ALL.map(crate::wire::Format::media_type);
            kinds.sort_unstable();
            known.sort_unstable();
            assert_eq!(kinds, known, "{path}");
        }
    }

    #[test]
    fn what_a_request_needs_is_said() {
        let api = api();
        let robot_of = |path: &str| {
            let parameters = api["paths"][path]["post"]["parameters"].as_array().unwrap();
            parameters.iter().find(|parameter| parameter["name"] == "robot").unwrap()["required"] == true
        };
        assert!(robot_of("/v1/strategy") && !robot_of("/v1/recognise"));
        for (path, required) in
            [("/v1/recognise", ["picture"].as_slice()), ("/v1/strategy", &["picture", "object", "camera"])]
        {
            let form = &api["paths"][path]["post"]["requestBody"]["content"]["multipart/form-data"]["schema"];
            let name = form["$ref"].as_str().and_then(|name| name.rsplit('/').next()).unwrap();
            let form = &api["components"]["schemas"][name];
            assert_eq!(form["required"], serde_json::json!(required), "{path}");
            assert_eq!(form["properties"]["picture"]["contentMediaType"], "application/octet-stream");
            // A part that is not there is none, and not null.
            assert_eq!(form["properties"]["mask"]["type"], "string", "{form}");
        }
    }

    /// An answer without the strategy that was asked for has all that a failure must have.
    #[test]
    fn a_record_may_be_like_an_answer_and_like_a_failure() {
        let schemas = &api()["components"]["schemas"];
        let record = &schemas["Record"];
        assert_eq!((record["anyOf"].as_array().map(Vec::len), &record["oneOf"]), (Some(2), &Value::Null));
        for needed in schemas["Failure"]["required"].as_array().unwrap() {
            assert!(!schemas["Answer"]["properties"][needed.as_str().unwrap()].is_null(), "{needed}");
        }
        for named in JSON.split("#/components/schemas/").skip(1) {
            let name = named.split('"').next().unwrap();
            assert!(!schemas[name].is_null(), "{name} is not described");
        }
    }
}
