//! The service: one mapped index, many askers, over HTTP.
//!
//! A request is let in by `guard` (token, host) and `gate` (how many at a time), its `body` is read and its
//! [`parameters`] are checked, the work is done on a thread that may block (`recognise`, `search`), and `metrics` count it.
//! `current` holds the index and replaces it when another file lies at its path; `listen` holds the connections,
//! `page` is what a browser is given. [`Service::run`] puts them together.

mod about;
mod body;
mod current;
mod explained;
mod gate;
mod guard;
mod identity;
mod listen;
mod metrics;
mod openapi;
mod page;
pub mod parameters;
mod problem;
mod recognise;
mod search;

use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, Request, State};
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::{Redirect, Response};
use axum::routing::{get, post};
use tokio::sync::Notify;

use crate::quiz;
pub(crate) use body::DESCRIBED;
use current::{Current, Looked, Served};
use gate::{Gate, Place};
use listen::Connections;
pub use listen::Listener;
use metrics::Metrics;
pub(crate) use page::LOOK;
use parameters::{PictureParameters, SearchParameters};
use problem::Problem;
use recognise::Form;

/// What the service allows.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The index's file.
    pub index: PathBuf,
    /// Read it into memory instead of mapping it.
    pub no_mmap: bool,
    /// Requests that are worked on at a time.
    pub workers: usize,
    /// Requests that may wait besides.
    pub queue: usize,
    /// The most bytes of a request's body.
    pub most_bytes: usize,
    /// The most pixels of a picture.
    pub most_pixels: u64,
    /// How long a request may take to arrive, and how long to be answered.
    pub timeout: Duration,
    /// How often to look whether another index lies at the path.
    pub poll: Duration,
    /// How long requests under way may take when the program ends.
    pub drain: Duration,
    /// What askers must show.
    pub token: Option<String>,
    /// Answer only to names of this machine.
    pub local_names_only: bool,
    /// Whether the page shall lead to the quiz.
    pub has_quiz: bool,
}

/// What to tell the one who runs the service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The index is open, for the first time or again, as this generation.
    Serving(u64),
    /// The file at the index's path cannot be used; the one before is served.
    StillTheOld(String),
}

/// How the service ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every request that was let in was answered.
    Drained,
    /// So many were not, when the time was over.
    CutShort(usize),
}

/// The service between requests.
#[derive(Debug)]
pub struct Service {
    settings: Settings,
    current: Current,
    gate: Gate,
    metrics: Metrics,
    draining: AtomicBool,
    reload: Notify,
}

type Shared = Arc<Service>;

impl Service {
    /// A service that has not opened its index yet.
    pub fn new(settings: Settings) -> Arc<Self> {
        Arc::new(Self {
            current: Current::new(settings.index.clone(), settings.no_mmap),
            gate: Gate::new(settings.workers, settings.queue),
            metrics: Metrics::default(),
            draining: AtomicBool::new(false),
            reload: Notify::new(),
            settings,
        })
    }

    /// Opens the index anew, whether or not another file lies at its path.
    pub fn reload(&self) {
        self.reload.notify_one();
    }

    /// Opens the index, and answers until `stop`; then finishes what was begun.
    ///
    /// # Errors
    /// Where the first index cannot be opened: what is wrong with it.
    pub async fn run(
        self: Arc<Self>,
        listeners: Vec<Listener>,
        quiz: Option<quiz::server::Table>,
        stop: impl Future<Output = ()>,
        tell: impl Fn(Event) + Send + 'static,
    ) -> Result<Ended, String> {
        let router = router(Arc::clone(&self), quiz);
        let connections = Arc::new(Connections::new());
        let accepting: Vec<_> = listeners
            .into_iter()
            .map(|listener| {
                let (connections, router) = (Arc::clone(&connections), router.clone());
                tokio::spawn(async move { connections.accept(&listener, &router).await })
            })
            .collect();
        let first = match self.look(false).await {
            Some(Looked::Replaced(generation)) => generation,
            Some(Looked::Failed(message)) => return Err(message),
            _ => return Err("the index cannot be opened".into()),
        };
        tell(Event::Serving(first));
        let watching = tokio::spawn(Arc::clone(&self).watch(tell));
        stop.await;
        let ended = self.drain().await;
        watching.abort();
        for task in accepting {
            task.abort();
            // The task lets go of the connections.
            let _ = task.await;
        }
        if let Some(connections) = Arc::into_inner(connections) {
            // What is left are answers on their way out and connections that lie idle.
            let _ = tokio::time::timeout(Duration::from_secs(1), connections.close()).await;
        }
        Ok(ended)
    }

    /// Waits for the requests that were let in; no other is, and `/readyz` says so.
    async fn drain(&self) -> Ended {
        self.draining.store(true, Ordering::SeqCst);
        let deadline = tokio::time::Instant::now() + self.settings.drain;
        while self.gate.inside() > 0 {
            if tokio::time::Instant::now() >= deadline {
                return Ended::CutShort(self.gate.inside());
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        Ended::Drained
    }

    async fn look(self: &Arc<Self>, forced: bool) -> Option<Looked> {
        let service = Arc::clone(self);
        tokio::task::spawn_blocking(move || service.current.look(forced)).await.ok()
    }

    /// Looks for another index now and then, and when it is told to.
    async fn watch(self: Arc<Self>, tell: impl Fn(Event)) {
        loop {
            let forced = tokio::select! {
                () = tokio::time::sleep(self.settings.poll) => false,
                () = self.reload.notified() => true,
            };
            match self.look(forced).await {
                Some(Looked::Replaced(generation)) => tell(Event::Serving(generation)),
                Some(Looked::Failed(message)) => tell(Event::StillTheOld(message)),
                Some(Looked::Unchanged) => {}
                None => self.metrics.panicked(),
            }
        }
    }

    fn is_draining(&self) -> bool {
        self.draining.load(Ordering::SeqCst)
    }

    /// The index to answer by.
    fn served(&self) -> Result<Arc<Served>, Problem> {
        self.current.get().ok_or_else(|| Problem::not_ready("has not opened its index yet"))
    }

    /// Lets a request in, before its body is read.
    fn enter(&self) -> Result<Place, Problem> {
        if self.is_draining() {
            return Err(Problem::not_ready("is about to end"));
        }
        self.gate.enter().ok_or_else(Problem::busy)
    }

    /// Reads what a request carries, in the time that it has.
    async fn read<T>(&self, body: impl Future<Output = Result<T, Problem>>) -> Result<T, Problem> {
        let too_slow = || {
            let message =
                "the request did not arrive in the time that it may take: send it faster, or less of it";
            Problem::new(StatusCode::REQUEST_TIMEOUT, "timeout", message)
        };
        tokio::time::timeout(self.settings.timeout, body).await.map_err(|_| too_slow())?
    }

    /// Answers on a thread that may block, in the time that there is.
    async fn work(
        &self,
        place: Place,
        work: impl FnOnce() -> Result<Response, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let answer = tokio::time::timeout(self.settings.timeout, self.gate.run(place, work)).await;
        answer.map_err(|_| Problem::too_slow())?.unwrap_or_else(|_| {
            self.metrics.panicked();
            Err(Problem::lost())
        })
    }
}

fn router(service: Shared, quiz: Option<quiz::server::Table>) -> Router {
    let mut router = Router::new()
        .route("/v1/recognise", post(recognise_picture))
        .route("/v1/strategy", post(robot_strategy))
        .route("/v1/search", post(search_descriptors))
        .route("/v1/index", get(about::index))
        .route("/v1/neighbours/{id}/thumbnail.png", get(about::thumbnail))
        .route("/healthz", get(about::health))
        .route("/readyz", get(about::ready))
        .route("/metrics", get(about::metrics))
        .route("/session", post(guard::session))
        .route("/openapi.json", get(async || ([(header::CONTENT_TYPE, "application/json")], openapi::json())))
        .merge(page::routes())
        .layer(DefaultBodyLimit::max(service.settings.most_bytes))
        .with_state(Arc::clone(&service));
    if let Some(table) = quiz {
        router = router
            .route("/quiz", get(async || Redirect::permanent("/quiz/")))
            .nest_service("/quiz/", quiz::server::router(table));
    }
    let missing = async || {
        Problem::new(StatusCode::NOT_FOUND, "not_found", "there is nothing here: /openapi.json tells what is")
    };
    router.fallback(missing).layer(middleware::from_fn_with_state(service, guard::guard))
}

/// `POST /v1/recognise`.
#[utoipa::path(post, path = "/v1/recognise", params(PictureParameters),
    request_body(description = "A PNG, JPEG or PNM picture, or a form (multipart/form-data) of `picture` and `mask` or `depth`",
        content(("application/octet-stream"), ("multipart/form-data"))),
    responses(
        (status = 200, description = "The record that `grasp-query recognise --json` prints; as text for `Accept: text/plain`, as the drawing of --explain for `Accept: image/png`",
            body = crate::output::record::Record),
        (status = 400, description = "The picture or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 401, description = "A token is needed", body = problem::ProblemRecord),
        (status = 413, description = "Too many bytes or pixels", body = problem::ProblemRecord),
        (status = 422, description = "The picture shows no hand", body = crate::output::record::Record),
        (status = 429, description = "Too many requests wait; Retry-After says when to try again", body = problem::ProblemRecord),
        (status = 503, description = "Not ready, or too slow", body = problem::ProblemRecord)))]
async fn recognise_picture(
    State(service): State<Shared>,
    parameters: Result<Query<PictureParameters>, QueryRejection>,
    request: Request,
) -> Result<Response, Problem> {
    let Query(parameters) = parameters.map_err(|rejection| Problem::bad_request(rejection.body_text()))?;
    let place = service.enter()?;
    let served = service.served()?;
    let form = Form::of(request.headers());
    let input = service.read(body::input(request)).await?;
    let worker = Arc::clone(&service);
    let most_pixels = service.settings.most_pixels;
    let work = move || recognise::answer(&served, &worker.metrics, &input, &parameters, form, most_pixels);
    service.work(place, work).await
}

/// `POST /v1/strategy`.
#[utoipa::path(post, path = "/v1/strategy", params(PictureParameters),
    request_body(description = "A form of `picture`, `object` and `camera` (TOML, as for --object and --camera), `robot` for robot=described, `arm` for arm=described",
        content_type = "multipart/form-data"),
    responses(
        (status = 200, description = "The record of /v1/recognise, whose `strategy` says what the robot does, or whose `error` says why it can do nothing. Where `strategy.feasible` is false, `strategy.problems` says what cannot be right, and the header `grasp-status` is 1: nobody should try it. For `Accept: application/yaml`, a moveit_msgs/Grasp",
            body = crate::output::record::Record),
        (status = 422, description = "The picture shows no hand; or, for `Accept: application/yaml`, there is no strategy or it is not feasible: the text says why, and no message is sent", body = crate::output::record::Record),
        (status = 400, description = "The picture, a description or a parameter cannot be used", body = problem::ProblemRecord)))]
async fn robot_strategy(
    service: State<Shared>,
    parameters: Result<Query<PictureParameters>, QueryRejection>,
    request: Request,
) -> Result<Response, Problem> {
    if parameters.as_ref().is_ok_and(|Query(parameters)| parameters.robot.is_none()) {
        return Err(Problem::bad_request(
            "say which robot: robot=barrett, robot=parallel-gripper or robot=described",
        ));
    }
    recognise_picture(service, parameters, request).await
}

/// `POST /v1/search`.
#[utoipa::path(post, path = "/v1/search", params(SearchParameters),
    request_body(description = "Descriptors: float32 in NumPy's format, or JSON", content((search::Queries = "application/json"), ("application/octet-stream"))),
    responses(
        (status = 200, description = "The lines that `grasp-query search --neighbours` prints, one a descriptor; with shortlist=true, lines of `probes`, `most_probes`, `keep` and `neighbours` with a `key` each", content_type = "application/x-ndjson",
            body = crate::output::found::QueryRecord),
        (status = 400, description = "A descriptor or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 413, description = "Too much at once", body = problem::ProblemRecord),
        (status = 429, description = "Too many requests wait", body = problem::ProblemRecord)))]
async fn search_descriptors(
    State(service): State<Shared>,
    parameters: Result<Query<SearchParameters>, QueryRejection>,
    request: Request,
) -> Result<Response, Problem> {
    let Query(parameters) = parameters.map_err(|rejection| Problem::bad_request(rejection.body_text()))?;
    let place = service.enter()?;
    let served = service.served()?;
    let body = service.read(body::bytes(request)).await?;
    service.work(place, move || search::answer(&served, &body, &parameters)).await
}
