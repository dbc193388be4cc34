//! The paths that make the service work: from a request to the thread that answers it.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::header;
use axum::response::Response;

use crate::body;
use crate::descriptors;
use crate::problem::{self, Problem};
use crate::query::Options;
use crate::recognise;
use crate::search;
use crate::service::Shared;
use crate::tags;
use crate::wire::Format;
use crate::wire::parameters::{PictureParameters, SearchParameters};

/// `POST /v1/recognise`.
#[utoipa::path(post, path = "/v1/recognise", tag = tags::PICTURES,
    summary = "Recognise the grasp in a picture",
    description = "Finds the hand in a picture, and by the nearest entries of the index which grasp it makes and how it is turned \
        toward the camera.\n\n    curl --data-binary @hand.jpg 'http://127.0.0.1:8750/v1/recognise?hand=right'\n\n    \
        curl -F picture=@hand.png -F mask=@mask.png http://127.0.0.1:8750/v1/recognise\n\nThe header `Accept` chooses the form \
        of the answer: `application/json` (the default), `text/plain`, or `image/png` for a drawing of how the answer came about. \
        The header `grasp-status` of the answer is the exit status that `grasp-query recognise` would have had (0 recognised, 1 \
        rejected, 2 an error), and `grasp-index-generation` says which index answered.",
    params(PictureParameters),
    request_body(description = "A picture as it is, or a form (multipart/form-data) of `picture` and `mask` (white where the hand \
        is), `depth` (with `depth_range`) or `landmarks` (where a tracker has the hand's 21 joints, as JSON: `{\"unit\": \"pixel\" or \
        \"share\", \"landmarks\": [[x, y], ...]}`, in MediaPipe's order).",
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
pub(crate) async fn recognise_picture(
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
#[utoipa::path(post, path = "/v1/strategy", tag = tags::PICTURES,
    summary = "Plan the same grasp for a robot hand",
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
pub(crate) async fn robot_strategy(
    service: State<Shared>,
    parameters: Options<PictureParameters>,
    request: Request,
) -> Result<Response, Problem> {
    if parameters.0.robot.is_none() {
        return Err(Problem::bad_request(
            "say which robot: robot=barrett, robot=robotiq-2f-85, another that comes with the program, or robot=described",
        ));
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
            body = grasp_answer::found::QueryRecord),
        (status = 400, description = "A descriptor or a parameter cannot be used", body = problem::ProblemRecord),
        (status = 413, description = "Too much at once", body = problem::ProblemRecord),
        (status = 429, description = "Too many requests wait", body = problem::ProblemRecord)))]
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
