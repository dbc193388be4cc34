//! Which path leads where.

use std::sync::Arc;

use axum::Router;
use axum::http::header;
use axum::middleware;
use axum::response::Redirect;
use axum::routing::{get, post};

use crate::problem::Problem;
use crate::service::Shared;
use crate::{about, docs, guard, openapi, page, work};

/// All paths, those of `quiz` below `/quiz/`.
pub(crate) fn router(service: Shared, quiz: Option<Router>) -> Router {
    let mut router = Router::new()
        .route("/v1/recognise", post(work::recognise_picture))
        .route("/v1/strategy", post(work::robot_strategy))
        .route("/v1/search", post(work::search_descriptors))
        .route("/v1/index", get(about::index))
        .route("/v1/neighbours/{id}/thumbnail.png", get(about::thumbnail))
        .route("/healthz", get(about::health))
        .route("/readyz", get(about::ready))
        .route("/metrics", get(about::metrics))
        .route("/session", post(guard::session))
        .route(
            "/openapi.json",
            get(async || ([(header::CONTENT_TYPE, "application/json")], openapi::JSON.as_str())),
        )
        .merge(docs::routes())
        .merge(page::routes())
        .with_state(Arc::clone(&service));
    if let Some(quiz) = quiz {
        router =
            router.route("/quiz", get(async || Redirect::permanent("/quiz/"))).nest_service("/quiz/", quiz);
    }
    let missing = async || Problem::missing("there is nothing here: /docs says what is");
    router
        .method_not_allowed_fallback(Problem::method_not_allowed)
        .fallback(missing)
        .layer(middleware::from_fn_with_state(service, guard::guard))
}
