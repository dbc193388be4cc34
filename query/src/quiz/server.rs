//! The page and its other end, over HTTP.
//!
//! `GET /` is the page, `GET /choices` the six grasps, `GET /state` where the quiz is, `GET /picture/N` the N-th picture,
//! `POST /answer` takes `{"picture": N, "answer": 1..6}`, and `POST /finish` ends the quiz and tells the result.

use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::{DefaultBodyLimit, Path, State as Shared};
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use tokio::net::TcpListener;

use super::result::QuizResult;
use super::{CHOICES, Quiz, Refused, State};
use crate::serve::LOOK;

/// An answer is some dozen bytes.
const MOST_BYTES: usize = 1024;

/// Nothing from elsewhere is loaded, nobody may frame the page, and nothing is kept that a later quiz would show again.
const HEADERS: [(HeaderName, &str); 4] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
];

/// The quiz, between requests.
#[derive(Clone, Debug)]
pub struct Table(Arc<Mutex<Quiz>>);

/// What the page sends.
#[derive(Debug, Deserialize)]
struct Answer {
    picture: usize,
    answer: usize,
}

impl Table {
    /// Puts a quiz where requests find it.
    pub fn new(quiz: Quiz) -> Self {
        Self(Arc::new(Mutex::new(quiz)))
    }

    /// The quiz, for as long as no request needs it.
    pub fn quiz(&self) -> MutexGuard<'_, Quiz> {
        // A request that panicked has not changed the quiz halfway: an answer counts in one step.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Answers requests until `stop`.
///
/// # Errors
/// Where the listener fails.
pub async fn serve(
    listener: TcpListener,
    table: Table,
    stop: impl Future<Output = ()>,
) -> std::io::Result<()> {
    tokio::select! {
        // Open connections are not waited for: a browser keeps them as long as its window is open.
        result = axum::serve(listener, router(table)).into_future() => result,
        () = stop => Ok(()),
    }
}

/// The paths of the quiz, to be served alone or beside others.
pub fn router(table: Table) -> Router {
    Router::new()
        .route("/", get(async || page("text/html; charset=utf-8", include_bytes!("page/index.html"))))
        .route("/look.css", get(async || page("text/css; charset=utf-8", LOOK)))
        .route("/quiz.css", get(async || page("text/css; charset=utf-8", include_bytes!("page/quiz.css"))))
        .route(
            "/quiz.js",
            get(async || page("text/javascript; charset=utf-8", include_bytes!("page/quiz.js"))),
        )
        .route("/examples.png", get(async || page("image/png", include_bytes!("page/examples.png"))))
        .route("/choices", get(async || (HEADERS, Json(CHOICES))))
        .route("/state", get(state))
        .route("/picture/{number}", get(picture))
        .route("/answer", post(answer))
        .route("/finish", post(finish))
        .layer(DefaultBodyLimit::max(MOST_BYTES))
        .with_state(table)
}

fn page(content_type: &'static str, bytes: &'static [u8]) -> Response {
    (HEADERS, [(header::CONTENT_TYPE, content_type)], bytes).into_response()
}

async fn state(Shared(table): Shared<Table>) -> (HeaderList, Json<State>) {
    (HEADERS, Json(table.quiz().state()))
}

async fn picture(Shared(table): Shared<Table>, Path(number): Path<usize>) -> Result<Response, Refused> {
    let png = table.quiz().picture(number)?;
    Ok((HEADERS, [(header::CONTENT_TYPE, "image/png")], png).into_response())
}

async fn answer(
    Shared(table): Shared<Table>,
    Json(answer): Json<Answer>,
) -> Result<(HeaderList, Json<State>), Refused> {
    let state = table.quiz().answer(answer.picture, answer.answer)?;
    Ok((HEADERS, Json(state)))
}

async fn finish(Shared(table): Shared<Table>) -> Result<(HeaderList, Json<QuizResult>), Refused> {
    Ok((HEADERS, Json(table.quiz().finish()?)))
}

type HeaderList = [(HeaderName, &'static str); 4];

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let status = match &self {
            Self::NoPicture(_) => StatusCode::NOT_FOUND,
            Self::NoChoice(_) => StatusCode::UNPROCESSABLE_ENTITY,
            Self::NotNow(_) | Self::Over | Self::Unfinished(_) => StatusCode::CONFLICT,
            Self::NotKept(_) => StatusCode::INTERNAL_SERVER_ERROR,
        };
        (status, HEADERS, self.to_string()).into_response()
    }
}
