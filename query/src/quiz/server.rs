//! The page and its other end, over HTTP.
//!
//! `GET /` is the page, `GET /choices` the six grasps, `GET /state` where the quiz is, `GET
//! /picture/N` the N-th picture, `POST /answer` takes `{"picture": N, "answer": 1..6}`, and `POST
//! /finish` ends the quiz and tells the result.

use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::rejection::PathRejection;
use axum::extract::{Path, Request, State as Shared};
use axum::http::{StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use tokio::net::TcpListener;

use super::result::QuizResult;
use super::{CHOICES, Quiz, Refused, State};
use grasp_serve::LOOK;
use grasp_serve::Problem;
use grasp_serve::browser::protected;
use grasp_serve::origin::{Names, check_host, check_origin};
use grasp_serve::small;

/// What the page is made of: anybody may link to it, and it tells nothing. All else answers to the
/// page alone.
const OPEN: [&str; 4] = ["/", "/look.css", "/quiz.css", "/quiz.js"];

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
    let names = Names::of_address(listener.local_addr()?);
    let guarded = router(table).layer(from_fn(move |request, next| guard(names, request, next)));
    tokio::select! {
        // Open connections are not waited for: a browser keeps them as long as its window is open.
        result = axum::serve(listener, guarded).into_future() => result,
        () = stop => Ok(()),
    }
}

/// Answers to this machine's own names, and to its own page.
async fn guard(names: Names, request: Request, next: Next) -> Response {
    let is_open = OPEN.contains(&request.uri().path());
    let checked = check_host(&request, names);
    protected(match checked.and_then(|()| if is_open { Ok(()) } else { check_origin(&request) }) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    })
}

/// The paths of the quiz, to be served alone or beside others, behind a guard.
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
        .route("/choices", get(async || Json(CHOICES)))
        .route("/state", get(state))
        .route("/picture/{number}", get(picture))
        .route("/answer", post(answer))
        .route("/finish", post(finish))
        .method_not_allowed_fallback(Problem::method_not_allowed)
        .fallback(async || Problem::missing("there is nothing here: the quiz is at /"))
        .with_state(table)
}

fn page(content_type: &'static str, bytes: &'static [u8]) -> Response {
    ([(header::CONTENT_TYPE, content_type)], bytes).into_response()
}

async fn state(Shared(table): Shared<Table>) -> Json<State> {
    Json(table.quiz().state())
}

async fn picture(
    Shared(table): Shared<Table>,
    number: Result<Path<usize>, PathRejection>,
) -> Result<Response, Problem> {
    let Ok(Path(number)) = number else {
        return Err(Problem::bad_request("a picture is named by its number, an integer from 0"));
    };
    let png = table.quiz().picture(number)?;
    Ok(([(header::CONTENT_TYPE, "image/png")], png).into_response())
}

async fn answer(Shared(table): Shared<Table>, request: Request) -> Result<Json<State>, Problem> {
    let answer: Answer = small::json(request, "{\"picture\": N, \"answer\": 1 to 6}").await?;
    let state = table.quiz().answer(answer.picture, answer.answer)?;
    Ok(Json(state))
}

async fn finish(Shared(table): Shared<Table>) -> Result<Json<QuizResult>, Problem> {
    Ok(Json(table.quiz().finish()?))
}

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let status = match &refused {
            Refused::NoPicture(_) => StatusCode::NOT_FOUND,
            Refused::NoChoice(_) => StatusCode::UNPROCESSABLE_ENTITY,
            Refused::NotNow(_) | Refused::Over | Refused::Unfinished(_) => StatusCode::CONFLICT,
            Refused::NotKept(_) => StatusCode::INTERNAL_SERVER_ERROR,
        };
        Self::new(status, "quiz", refused.to_string())
    }
}
