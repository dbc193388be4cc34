//! What the service says about itself and its index.

use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use image::ExtendedColorType;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::current::LOST;
use super::explained::png;
use super::metrics::{CONTENT_TYPE, Gauges};
use super::problem::Problem;
use super::query::Options;
use super::refusals::{Guarded, Named};
use super::service::Shared;
use super::shown::shown;
use super::tags;
use grasp_about::{EffortInfo, HashInfo, MeasuredInfo};
use grasp_index::EPS_GRID;

/// The index that is served. Its keys are an interface: they may be added to, never renamed.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct IndexRecord {
    /// The file.
    file: String,
    /// 1 for the first index that was served, one more with each replacement.
    generation: u64,
    /// When it was opened, in seconds since 1970.
    opened_at: u64,
    /// Its length in bytes.
    bytes: u64,
    entries: usize,
    /// Values of a descriptor.
    dim: usize,
    /// Whether it can tell what pictures show.
    recognises: bool,
    classes: Vec<ClassName>,
    hand_shapes: Vec<String>,
    stages: Vec<String>,
    /// `learned` or `random`.
    hash: &'static str,
    /// How many neighbours vote.
    k: u32,
    /// Sides of the thumbnails in pixels; 0 where there are none.
    thumbnail_side: u32,
    /// What a search finds, as measured when the index was built.
    efforts: Vec<EffortInfo>,
    /// The values of eps that `eps_success` is given for.
    eps: [f64; EPS_GRID.len()],
    /// Whether people can name grasps at /quiz/.
    quiz: bool,
    /// Where the index comes from, as its builder states it.
    provenance: Vec<(String, String)>,
}

/// A class of the index.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ClassName {
    grasp: String,
    cutkosky: u8,
}

/// `GET /v1/index`.
#[utoipa::path(get, path = "/v1/index", tag = tags::INDEX,
    summary = "Describe the index that is served",
    description = "Its classes and size, what its searches find at each effort, and where it comes from.",
    responses((status = 200, description = "The index", body = IndexRecord),
        Guarded,
        (status = 503, description = "No index is open yet", body = super::problem::ProblemRecord)))]
pub(super) async fn index(State(service): State<Shared>) -> Result<Json<IndexRecord>, Problem> {
    let served = service.served()?;
    let (index, catalogue) = (&served.index, served.index.catalogue());
    let classes = catalogue.classes.iter();
    let measured = MeasuredInfo::from(&catalogue.measured);
    Ok(Json(IndexRecord {
        file: service.current.path().display().to_string(),
        generation: served.generation,
        opened_at: served.opened_at,
        bytes: index.byte_len(),
        entries: index.len(),
        dim: index.dim(),
        recognises: index.check_recognises().is_ok(),
        classes: classes
            .map(|class| ClassName { grasp: class.name.clone(), cutkosky: class.cutkosky })
            .collect(),
        hand_shapes: catalogue.hand_shapes.clone(),
        stages: catalogue.stages.clone(),
        hash: HashInfo::from_hash(&catalogue.hash).map_or("unknown", |hash| hash.kind()),
        k: catalogue.calibration.k,
        thumbnail_side: catalogue.thumbnail_side,
        efforts: measured.curve,
        eps: measured.eps,
        quiz: service.settings.has_quiz,
        provenance: catalogue.provenance.clone(),
    }))
}

/// Which index a neighbour belongs to.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct IndexGeneration {
    /// The index that named the neighbour, from the header `grasp-index-generation`; another one
    /// has other entries.
    #[param(maximum = 18_446_744_073_709_551_615u64)]
    generation: Option<u64>,
}

/// `GET /v1/neighbours/{id}/thumbnail.png`.
#[utoipa::path(get, path = "/v1/neighbours/{id}/thumbnail.png", tag = tags::INDEX,
    summary = "Show an entry's picture",
    description = "The hand image of an entry that `neighbours` of a record names by its `id`.",
    params(("id" = u32, Path, description = "The entry's number"), IndexGeneration),
    responses((status = 200, description = "The entry's picture, grey", content_type = "image/png"),
        (status = 400, description = "What is named is no entry's number", body = super::problem::ProblemRecord),
        Guarded,
        (status = 404, description = "There is no such entry, or it has no picture", body = super::problem::ProblemRecord),
        (status = 410, description = "The index that named the entry is no longer served", body = super::problem::ProblemRecord),
        (status = 503, description = "No index is open yet", body = super::problem::ProblemRecord)))]
pub(super) async fn thumbnail(
    State(service): State<Shared>,
    id: Result<Path<String>, PathRejection>,
    Options(of): Options<IndexGeneration>,
) -> Result<Response, Problem> {
    // What is no text is no number either.
    let id = id.map_or_else(|_| String::new(), |Path(id)| id);
    let id: u32 = id.parse().map_err(|_| {
        Problem::bad_request(format!(
            "{} is no entry: its number is an integer from 0 to {}",
            shown(&id),
            u32::MAX
        ))
    })?;
    let served = service.served()?;
    if of.generation.is_some_and(|generation| generation != served.generation) {
        let message = "the index that named this entry has been replaced: ask again what the picture shows";
        return Err(Problem::new(StatusCode::GONE, "replaced", message));
    }
    let missing =
        || Problem::new(StatusCode::NOT_FOUND, "no_thumbnail", format!("entry {id} has no picture"));
    let side = served.index.catalogue().thumbnail_side as usize;
    let thumbnail = served.index.thumbnail(id);
    // Also before one is missed: of a file that was cut short, all are zeros.
    service.check(&served)?;
    let grey = thumbnail.ok_or_else(missing)?;
    let bytes = png(grey, (side, side), ExtendedColorType::L8).map_err(|_| Problem::lost())?;
    service.check(&served)?;
    Ok(([(header::CONTENT_TYPE, "image/png")], bytes).into_response())
}

/// Whether requests are answered, and what is wrong where they are not, or where a new index could
/// not be used.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Ready {
    ready: bool,
    /// `serving`, `opening`, `draining`, or `lost`: the file that was served has been overwritten
    /// or truncated.
    state: &'static str,
    /// The index that is served; null before the first.
    generation: Option<u64>,
    /// How many new index files could not be used.
    reload_failures: u64,
    /// What is wrong with the file that lies at the index's path now; null where nothing is.
    problem: Option<String>,
}

/// `GET /readyz`.
#[utoipa::path(get, path = "/readyz", tag = tags::OPERATION,
    summary = "Say whether requests are answered",
    description = "For a load balancer, and for those who replace the index: `problem` says why the file that lies at its path now \
        is not the one that is served.",
    security(()),
    responses((status = 200, description = "Requests are answered", body = Ready),
    Named,
    (status = 503, description = "The index is not open yet or its file was overwritten, or the service is about to end", body = Ready)))]
pub(super) async fn ready(State(service): State<Shared>) -> Response {
    let generation = service.current.get().map(|served| served.generation);
    let (failures, is_lost) = (service.current.failures(), service.current.is_lost());
    if is_lost {
        // Whoever asks is waiting: the file may be whole again.
        service.lost.notify_one();
    }
    let state = match (service.is_draining(), generation) {
        (true, _) => "draining",
        (false, None) => "opening",
        (false, Some(_)) if is_lost => "lost",
        (false, Some(_)) => "serving",
    };
    let ready = state == "serving";
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let path = service.current.path().display().to_string();
    let problem = failures.current.map(|problem| without(&problem.to_string(), &path));
    let problem = problem.or_else(|| is_lost.then(|| format!("the service {LOST}")));
    let record = Ready { ready, state, generation, reload_failures: failures.count, problem };
    (status, Json(record)).into_response()
}

/// A message without a path that it names: anybody may read it.
fn without(message: &str, path: &str) -> String {
    if path.is_empty() { message.into() } else { message.replace(&format!(" {path}"), "") }
}

/// `GET /healthz`.
#[utoipa::path(get, path = "/healthz", tag = tags::OPERATION,
    summary = "Say whether the program runs",
    description = "Answers `ok` for as long as the process lives, whatever it does.",
    security(()),
    responses((status = 200, description = "The program runs", body = String, content_type = "text/plain"), Named))]
pub(super) async fn health() -> &'static str {
    "ok\n"
}

/// `GET /metrics`.
#[utoipa::path(get, path = "/metrics", tag = tags::OPERATION,
    summary = "Count requests, their times and the index's replacements",
    description = "Counters and histograms since the start, in the text form of OpenMetrics, which Prometheus reads.",
    responses((status = 200, description = "The counters", body = String, content_type = "application/openmetrics-text"), Guarded))]
pub(super) async fn metrics(State(service): State<Shared>) -> Response {
    let (served, failures) = (service.current.get(), service.current.failures());
    let now = Gauges {
        generation: served.as_ref().map_or(0, |served| served.generation),
        entries: served.as_ref().map_or(0, |served| served.index.len() as u64),
        reload_failures: failures.count,
        index_is_stale: failures.current.is_some() || service.current.is_lost(),
        arriving: service.arriving(),
        reserved: service.budget.reserved(),
        inside: service.gate.inside(),
        ready: served.is_some_and(|served| !served.is_lost()) && !service.is_draining(),
    };
    let kind = HeaderValue::from_static(CONTENT_TYPE);
    ([(header::CONTENT_TYPE, kind)], service.metrics.text(now)).into_response()
}
