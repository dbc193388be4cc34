//! The service: one mapped index, many askers, over HTTP.
//!
//! `guard` lets requests in (by [`origin`] and [`Token`]) and checks their parameters (`query`);
//! bodies arrive within a `budget` of memory (`arrival`), and only what is whole passes the `gate`,
//! which bounds the work. It is done on a thread that may block (`recognise`, `search`), and
//! `metrics` count it. `current` holds the index and replaces it when another file lies at its
//! path; `listen` holds the connections, `page` is what a browser is given. [`Service::run`] puts
//! them together. [`client`] is the other end, and [`wire`] what crosses the line between both.

mod about;
mod arrival;
mod body;
mod budget;
pub mod client;
mod current;
mod descriptors;
mod docs;
mod explained;
mod form;
mod gate;
mod guard;
mod identity;
mod impatient;
mod linger;
mod listen;
mod metrics;
mod openapi;
pub mod origin;
mod page;
mod problem;
mod query;
mod recognise;
mod search;
pub mod small;
pub mod wire;

use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::header;
use axum::middleware;
use axum::response::{Redirect, Response};
use axum::routing::{get, post};
use tokio::sync::Notify;

use budget::Budget;
use current::{Current, LOST, Looked, Served};
use gate::{Gate, Place};
use listen::Connections;
pub use listen::Listener;
use metrics::Metrics;
pub use page::LOOK;
pub use problem::Problem;
use query::Options;
use wire::parameters::{PictureParameters, SearchParameters};
use wire::{Format, Token};

/// What the service allows.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The index's file.
    pub index: PathBuf,
    /// Where it has at most so many bytes, read it into memory instead of mapping it: it is then served on while another file
    /// is copied over it.
    pub most_read: u64,
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
    /// What askers must show; without it, the service answers under names of this machine alone.
    pub token: Option<Token>,
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
    /// The file that was served has been overwritten or truncated: requests are turned away until it is whole.
    Lost,
    /// The file at the index's path cannot be used, and the one before is lost.
    StillNone(String),
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
    budget: Arc<Budget>,
    arriving: AtomicUsize,
    gate: Gate,
    metrics: Metrics,
    draining: AtomicBool,
    reload: Notify,
    /// A request has noticed that the index is lost.
    lost: Notify,
}

/// How soon to look again where the index is lost or another is on its way.
const SOON: Duration = Duration::from_millis(50);

type Shared = Arc<Service>;

/// How many bodies of the largest size may be in memory at a time.
const BODIES: usize = 4;

impl Service {
    /// A service that has not opened its index yet.
    pub fn new(settings: Settings) -> Arc<Self> {
        Arc::new(Self {
            current: Current::new(settings.index.clone(), settings.most_read),
            budget: Arc::new(Budget::new(settings.most_bytes.saturating_mul(BODIES))),
            arriving: AtomicUsize::new(0),
            gate: Gate::new(settings.workers, settings.queue),
            metrics: Metrics::default(),
            draining: AtomicBool::new(false),
            reload: Notify::new(),
            lost: Notify::new(),
            settings,
        })
    }

    /// Opens the index anew, whether or not another file lies at its path.
    pub fn reload(&self) {
        self.reload.notify_one();
    }

    /// Opens the index, and answers until `stop`; then finishes what was begun. The paths of `quiz`, where there is one, lie
    /// below `/quiz/`.
    ///
    /// # Errors
    /// Where the first index cannot be opened: what is wrong with it.
    pub async fn run(
        self: Arc<Self>,
        listeners: Vec<Listener>,
        quiz: Option<Router>,
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
        loop {
            let left = self.arriving() + self.gate.inside();
            if left == 0 {
                return Ended::Drained;
            }
            if tokio::time::Instant::now() >= deadline {
                return Ended::CutShort(left);
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    async fn look(self: &Arc<Self>, forced: bool) -> Option<Looked> {
        let service = Arc::clone(self);
        tokio::task::spawn_blocking(move || service.current.look(forced)).await.ok()
    }

    /// Looks for another index now and then, and when it is told to.
    async fn watch(self: Arc<Self>, tell: impl Fn(Event)) {
        let mut pause = self.settings.poll;
        loop {
            let forced = tokio::select! {
                () = tokio::time::sleep(pause) => false,
                () = self.lost.notified() => false,
                () = self.reload.notified() => true,
            };
            let looked = self.look(forced).await;
            let is_lost = self.current.is_lost();
            pause = match looked {
                Some(Looked::OnItsWay) => self.settings.poll.min(SOON),
                _ if is_lost => self.settings.poll.min(SOON),
                _ => self.settings.poll,
            };
            match looked {
                Some(Looked::Replaced(generation)) => tell(Event::Serving(generation)),
                Some(Looked::Failed(message)) if is_lost => tell(Event::StillNone(message)),
                Some(Looked::Failed(message)) => tell(Event::StillTheOld(message)),
                Some(Looked::Lost) => tell(Event::Lost),
                Some(Looked::Unchanged | Looked::OnItsWay) => {}
                None => self.metrics.panicked(),
            }
        }
    }

    fn is_draining(&self) -> bool {
        self.draining.load(Ordering::SeqCst)
    }

    /// The index to answer by.
    fn served(&self) -> Result<Arc<Served>, Problem> {
        let served = self.current.get().ok_or_else(|| Problem::not_ready("has not opened its index yet"))?;
        self.check(&served)?;
        Ok(served)
    }

    /// Whether what the index has said may be believed: asked after each answer, before it is sent.
    fn check(&self, served: &Served) -> Result<(), Problem> {
        if served.is_lost() {
            self.lost.notify_one();
            return Err(Problem::not_ready(LOST));
        }
        Ok(())
    }

    /// Requests whose bodies are under way.
    fn arriving(&self) -> usize {
        self.arriving.load(Ordering::SeqCst)
    }

    /// Reads what a request carries, and then lets it in: what is not whole takes nobody's place.
    async fn receive(&self, request: Request) -> Result<(Bytes, Place), Problem> {
        if self.is_draining() {
            return Err(Problem::not_ready("is about to end"));
        }
        if self.gate.is_full() {
            return Err(Problem::busy());
        }
        let _arriving = Arriving::new(&self.arriving);
        let body = arrival::read(request.into_body(), self.settings.most_bytes, &self.budget);
        let body = tokio::time::timeout(self.settings.timeout, body).await.map_err(|_| Problem::late())??;
        let place = self.gate.enter().ok_or_else(Problem::busy)?;
        Ok((body, place))
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

/// Counts a request whose body is under way.
#[derive(Debug)]
struct Arriving<'a>(&'a AtomicUsize);

impl<'a> Arriving<'a> {
    fn new(count: &'a AtomicUsize) -> Self {
        count.fetch_add(1, Ordering::SeqCst);
        Self(count)
    }
}

impl Drop for Arriving<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn router(service: Shared, quiz: Option<Router>) -> Router {
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

/// `POST /v1/recognise`.
#[utoipa::path(post, path = "/v1/recognise", tag = openapi::PICTURES,
    summary = "Recognise the grasp in a picture",
    description = "Finds the hand in a picture, and by the nearest entries of the index which grasp it makes and how it is turned \
        toward the camera.\n\n    curl --data-binary @hand.jpg 'http://127.0.0.1:8750/v1/recognise?hand=right'\n\n    \
        curl -F picture=@hand.png -F mask=@mask.png http://127.0.0.1:8750/v1/recognise\n\nThe header `Accept` chooses the form \
        of the answer: `application/json` (the default), `text/plain`, or `image/png` for a drawing of how the answer came about. \
        The header `grasp-status` of the answer is the exit status that `grasp-query recognise` would have had (0 recognised, 1 \
        rejected, 2 an error), and `grasp-index-generation` says which index answered.",
    params(PictureParameters),
    request_body(description = "A picture as it is, or a form (multipart/form-data) of `picture` and `mask` (white where the hand \
        is) or `depth` (with `depth_range`).",
        content(("application/octet-stream"), ("multipart/form-data"))),
    responses(
        (status = 200, description = "The record that `grasp-query recognise --json` prints; with `explained=true` an `ExplainedRecord`",
            body = grasp_answer::record::Record),
        (status = 400, description = "The picture or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 401, description = "A token is needed", body = problem::ProblemRecord),
        (status = 403, description = "A page of another origin asks", body = problem::ProblemRecord),
        (status = 408, description = "The body came too slowly", body = problem::ProblemRecord),
        (status = 413, description = "Too many bytes or pixels", body = problem::ProblemRecord),
        (status = 422, description = "The picture shows no hand", body = grasp_answer::record::Record),
        (status = 429, description = "Too many requests wait, or too many bytes; `Retry-After` says when to try again", body = problem::ProblemRecord),
        (status = 503, description = "Not ready, or too slow", body = problem::ProblemRecord)))]
async fn recognise_picture(
    State(service): State<Shared>,
    Options(parameters): Options<PictureParameters>,
    request: Request,
) -> Result<Response, Problem> {
    service.served()?;
    let accept = request.headers().get(header::ACCEPT).and_then(|accept| accept.to_str().ok());
    let format = Format::of_accept(accept.unwrap_or_default());
    let content_type = request.headers().get(header::CONTENT_TYPE).cloned();
    let (body, place) = service.receive(request).await?;
    let input = body::input(content_type.as_ref(), body)?;
    let served = service.served()?;
    let worker = Arc::clone(&service);
    let most_pixels = service.settings.most_pixels;
    let work = move || {
        let answer = recognise::answer(&served, &worker.metrics, &input, &parameters, format, most_pixels);
        worker.check(&served)?;
        answer
    };
    service.work(place, work).await
}

/// `POST /v1/strategy`.
#[utoipa::path(post, path = "/v1/strategy", tag = openapi::PICTURES,
    summary = "Say how a robot hand would grasp alike",
    description = "Recognises the grasp as `/v1/recognise` does, and says where a robot's palm goes, how its fingers close and how it \
        lifts the object.\n\n    curl -F picture=@hand.jpg -F object=@bottle.toml -F camera=@camera.toml \
        'http://127.0.0.1:8750/v1/strategy?robot=barrett'\n\nFor `Accept: application/yaml` the answer is a `moveit_msgs/Grasp`.",
    params(PictureParameters),
    request_body(description = "A form of `picture`, `object` and `camera` (TOML, as for `--object` and `--camera`), `robot` for \
        `robot=described` and `arm` for `arm=described`.",
        content_type = "multipart/form-data"),
    responses(
        (status = 200, description = "The record of `/v1/recognise`, whose `strategy` says what the robot does, or whose `error` says why \
            it can do nothing. Where `strategy.feasible` is false, `strategy.problems` says what cannot be right, and the header \
            `grasp-status` is 1: nobody should try it.",
            body = grasp_answer::record::Record),
        (status = 400, description = "The picture, a description or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 422, description = "The picture shows no hand; or, for `Accept: application/yaml`, there is no strategy or it is not \
            feasible: the text says why, and no message is sent", body = grasp_answer::record::Record)))]
async fn robot_strategy(
    service: State<Shared>,
    parameters: Options<PictureParameters>,
    request: Request,
) -> Result<Response, Problem> {
    if parameters.0.robot.is_none() {
        return Err(Problem::bad_request(
            "say which robot: robot=barrett, robot=parallel-gripper or robot=described",
        ));
    }
    recognise_picture(service, parameters, request).await
}

/// `POST /v1/search`.
#[utoipa::path(post, path = "/v1/search", tag = openapi::DESCRIPTORS,
    summary = "Find the nearest entries of descriptors",
    description = "Searches the index for each row of an array, as `grasp-query search --neighbours` does.\n\n    \
        curl --data-binary @queries.npy 'http://127.0.0.1:8750/v1/search?k=5'\n\n    \
        curl --json '{\"descriptors\": [[0.1, 0.2]]}' http://127.0.0.1:8750/v1/search\n\nThe answer has a line of JSON for each \
        row. With `shortlist=true` the lines hold `probes`, `most_probes`, `keep` and `neighbours` with a `key` each.",
    params(SearchParameters),
    request_body(description = "Rows of as many numbers as `dim` of `/v1/index`: float32 in NumPy's format, or JSON.",
        content((descriptors::Described = "application/json"), ("application/octet-stream"))),
    responses(
        (status = 200, description = "A line of JSON for each descriptor", content_type = "application/x-ndjson",
            body = grasp_answer::found::QueryRecord),
        (status = 400, description = "A descriptor or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 413, description = "Too much at once", body = problem::ProblemRecord),
        (status = 429, description = "Too many requests wait", body = problem::ProblemRecord)))]
async fn search_descriptors(
    State(service): State<Shared>,
    Options(parameters): Options<SearchParameters>,
    request: Request,
) -> Result<Response, Problem> {
    service.served()?;
    let (body, place) = service.receive(request).await?;
    let served = service.served()?;
    let worker = Arc::clone(&service);
    let work = move || {
        let answer = search::answer(&served, &body, &parameters);
        worker.check(&served)?;
        answer
    };
    service.work(place, work).await
}
