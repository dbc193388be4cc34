//! The paths that make the service work: from a request to the thread that answers it.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;

use grasp_answer::found::QueryRecord;
use grasp_answer::record::Record;

use crate::body;
use crate::described_form::{PictureForm, StrategyForm};
use crate::descriptors;
use crate::problem::{Problem, ProblemRecord};
use crate::query::Options;
use crate::recognise;
use crate::refusals::Worked;
use crate::search;
use crate::service::Shared;
use crate::shown::shown;
use crate::tags;
use crate::wire::parameters::{PictureParameters, SearchParameters, StrategyParameters};
use crate::wire::{Format, wanted};

/// What is said where a robot is needed and none is named.
const WHICH_ROBOT: &str = "say which robot: robot=barrett, robot=robotiq-2f-85, another that comes with the program, or robot=described";

/// `POST /v1/recognise`.
#[utoipa::path(post, path = "/v1/recognise", tag = tags::PICTURES,
    summary = "Recognise the grasp in a picture",
    description = "Finds the hand in a picture, and by the nearest entries of the index which grasp it makes and how it is turned \
        toward the camera.\n\n    curl --data-binary @hand.jpg 'http://127.0.0.1:8750/v1/recognise?hand=right'\n\n    \
        curl -F picture=@hand.png -F mask=@mask.png http://127.0.0.1:8750/v1/recognise\n\nThe header `Accept` chooses the form \
        of the answer: `application/json` (the default), `text/plain`, `image/png` for a drawing of how the answer came about, or, \
        with `robot`, `application/yaml` for a `moveit_msgs/Grasp`. Why there is no answer is said in JSON, or as text where that \
        or YAML is asked for. The header `grasp-status` of the answer is the exit status that `grasp-query recognise` would have had (0 recognised, 1 \
        rejected, 2 an error), and `grasp-index-generation` says which index answered.",
    params(PictureParameters),
    request_body(description = "A picture as it is, or a form (multipart/form-data) of `picture` and `mask` (white where the hand \
        is), `depth` (with `depth_range`) or `landmarks` (where a tracker has the hand's 21 joints, as JSON: `{\"unit\": \"pixel\" or \
        \"share\", \"landmarks\": [[x, y], ...]}`, in MediaPipe's order).",
        content(("application/octet-stream"), (PictureForm = "multipart/form-data"))),
    responses(
        (status = 200, description = "The record that `grasp-query recognise --json` prints; with `explained=true` an `ExplainedRecord`",
            content((Record = "application/json"), (String = "text/plain"), ("image/png"), (String = "application/yaml"))),
        (status = 400, description = "The picture or a parameter cannot be used",
            content((ProblemRecord = "application/json"), (String = "text/plain"))),
        (status = 406, description = "The header `Accept` takes none of the forms of an answer", body = ProblemRecord),
        (status = 409, description = "The index that is served recognises no pictures", body = ProblemRecord),
        (status = 422, description = "The picture shows no hand, or, for `Accept: application/yaml`, there is no strategy that could be tried",
            content((Record = "application/json"), (String = "text/plain"))),
        Worked))]
pub(crate) async fn recognise_picture(
    State(service): State<Shared>,
    Options(parameters): Options<PictureParameters>,
    request: Request,
) -> Result<Response, Problem> {
    service.served()?;
    let format = format(request.headers())?;
    if format == Format::Moveit && parameters.robot.is_none() {
        return Err(Problem::bad_request(WHICH_ROBOT));
    }
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

/// The form that the answer is wanted in.
fn format(headers: &HeaderMap) -> Result<Format, Problem> {
    let accept: Vec<_> = headers
        .get_all(header::ACCEPT)
        .iter()
        .map(|value| String::from_utf8_lossy(value.as_bytes()))
        .collect();
    let accept = accept.join(", ");
    wanted(&accept).ok_or_else(|| {
        let known = Format::ALL.map(Format::media_type).join(", ");
        let message = format!("the header Accept is {}: answers are one of {known}", shown(&accept));
        Problem::new(StatusCode::NOT_ACCEPTABLE, "accept", message)
    })
}

/// `POST /v1/strategy`.
#[utoipa::path(post, path = "/v1/strategy", tag = tags::PICTURES,
    summary = "Plan the same grasp for a robot hand",
    description = "Recognises the grasp as `/v1/recognise` does, and says where a robot's palm goes, how its fingers close and how it \
        lifts the object.\n\n    curl -F picture=@hand.jpg -F object=@bottle.toml -F camera=@camera.toml \
        'http://127.0.0.1:8750/v1/strategy?robot=barrett'\n\nFor `Accept: application/yaml` the answer is a `moveit_msgs/Grasp`.",
    params(StrategyParameters),
    request_body(description = "A form of `picture`, `object` and `camera` (TOML, as for `--object` and `--camera`), `robot` for \
        `robot=described` and `arm` for `arm=described`.",
        content((StrategyForm = "multipart/form-data"))),
    responses(
        (status = 200, description = "The record of `/v1/recognise`, whose `strategy` says what the robot does, or whose `error` says why \
            it can do nothing. Where `strategy.feasible` is false, `strategy.problems` says what cannot be right, and the header \
            `grasp-status` is 1: nobody should try it.",
            content((Record = "application/json"), (String = "text/plain"), ("image/png"), (String = "application/yaml"))),
        (status = 400, description = "The picture, a description or a parameter cannot be used",
            content((ProblemRecord = "application/json"), (String = "text/plain"))),
        (status = 406, description = "The header `Accept` takes none of the forms of an answer", body = ProblemRecord),
        (status = 409, description = "The index that is served recognises no pictures", body = ProblemRecord),
        (status = 422, description = "The picture shows no hand; or, for `Accept: application/yaml`, there is no strategy or it is not \
            feasible: the text says why, and no message is sent",
            content((Record = "application/json"), (String = "text/plain"))),
        Worked))]
pub(crate) async fn robot_strategy(
    service: State<Shared>,
    parameters: Options<PictureParameters>,
    request: Request,
) -> Result<Response, Problem> {
    if parameters.0.robot.is_none() {
        return Err(Problem::bad_request(WHICH_ROBOT));
    }
    recognise_picture(service, parameters, request).await
}

/// `POST /v1/search`.
#[utoipa::path(post, path = "/v1/search", tag = tags::DESCRIPTORS,
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
            body = QueryRecord),
        (status = 400, description = "A descriptor or a parameter cannot be used", body = ProblemRecord),
        Worked))]
pub(crate) async fn search_descriptors(
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
