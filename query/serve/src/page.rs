//! The page, built into the program.

use axum::Router;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::service::Shared;

/// What all pages look alike in.
pub const LOOK: &[u8] = include_bytes!("page/look.css");

/// Path, content type and bytes of each file of the page.
const FILES: &[(&str, &str, &[u8])] = &[
    ("/", "text/html; charset=utf-8", include_bytes!("page/index.html")),
    ("/look.css", "text/css; charset=utf-8", LOOK),
    ("/page.css", "text/css; charset=utf-8", include_bytes!("page/page.css")),
    ("/page.js", "text/javascript; charset=utf-8", include_bytes!("page/page.js")),
    ("/answer.js", "text/javascript; charset=utf-8", include_bytes!("page/answer.js")),
    ("/camera.js", "text/javascript; charset=utf-8", include_bytes!("page/camera.js")),
    ("/examples.js", "text/javascript; charset=utf-8", include_bytes!("page/examples.js")),
    ("/hand.js", "text/javascript; charset=utf-8", include_bytes!("page/hand.js")),
    ("/robot.js", "text/javascript; charset=utf-8", include_bytes!("page/robot.js")),
    ("/icon.svg", "image/svg+xml", include_bytes!("page/icon.svg")),
    ("/bottle.toml", "text/plain; charset=utf-8", include_bytes!("../../data/objects/bottle.toml")),
    ("/camera.toml", "text/plain; charset=utf-8", include_bytes!("../../data/objects/camera.toml")),
    ("/hand.mesh", "application/octet-stream", include_bytes!("page/hand.mesh")),
    ("/samples/ball.jpg", "image/jpeg", include_bytes!("page/samples/ball.jpg")),
    ("/samples/handle.jpg", "image/jpeg", include_bytes!("page/samples/handle.jpg")),
];

/// Whether a path is that of a file of the page.
pub(super) fn has(path: &str) -> bool {
    FILES.iter().any(|(name, ..)| *name == path)
}

pub(super) fn routes() -> Router<Shared> {
    FILES.iter().fold(Router::new(), |router, &(path, kind, bytes)| {
        router.route(path, get(move || async move { file(kind, bytes) }))
    })
}

fn file(kind: &'static str, bytes: &'static [u8]) -> Response {
    ([(header::CONTENT_TYPE, kind)], bytes).into_response()
}
