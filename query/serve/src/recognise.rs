//! `POST /v1/recognise`: the work, between a body that was read and an answer that is sent.

use axum::body::Bytes;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::body::Input;
use super::current::Served;
use super::explained::Explained;
use super::metrics::Metrics;
use super::problem::Problem;
use crate::wire::parameters::PictureParameters;
use crate::wire::{Format, GENERATION, STATUS};
use grasp_answer::explain;
use grasp_answer::record::{Answer, Record};
use grasp_answer::{human, moveit};
use grasp_recognise::{RecogniseError, Recogniser};

/// A record and, where that was asked for, what a drawing of it needs.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ExplainedRecord {
    #[serde(flatten)]
    record: Record,
    explained: Explained,
}

/// Recognises a picture; runs on a thread that may block.
pub(super) fn answer(
    served: &Served,
    metrics: &Metrics,
    input: &Input,
    parameters: &PictureParameters,
    format: Format,
    most_pixels: u64,
) -> Result<Response, Problem> {
    let index = &served.index;
    index
        .check_recognises()
        .map_err(|error| Problem::new(StatusCode::CONFLICT, "index", error.to_string()))?;
    let options = parameters.options()?;
    input.check_pixels(most_pixels)?;
    let range = parameters.depth_range()?;
    let source = input.source(parameters.segmented, range)?;
    let setting = input.setting(parameters.robot.as_deref(), parameters.arm.as_deref())?;
    let name = parameters.file.clone().unwrap_or_else(|| "-".into());
    let found = match Recogniser::new(index, options).recognise(&input.picture, &source) {
        Ok(found) => found,
        Err(error) => {
            let record = Record::not_recognised(name, parameters.frame, &error);
            return render(&record, format, status_of(&error), served.generation);
        }
    };
    metrics.recognised(&found.timings, found.best.cost.candidates);
    let mut record = match Record::answer(name.clone(), parameters.frame, &found, index, parameters.timings) {
        Ok(record) => record,
        Err(error) => {
            let record = Record::failed(name, parameters.frame, "index", error.to_string());
            return render(&record, format, StatusCode::INTERNAL_SERVER_ERROR, served.generation);
        }
    };
    if let (Record::Answer(answer), Some(setting)) = (&mut record, &setting) {
        answer.imitate(&found, setting);
    }
    match (&record, format) {
        (Record::Answer(answer), Format::Moveit) => Ok(grasp_message(&record, answer, served.generation)),
        (Record::Answer(answer), Format::Drawing) => {
            let sheet = explain::draw(&found, answer, index);
            let drawing = explain::Format::Png.encode(&sheet).map_err(|_| Problem::lost())?;
            Ok(send(&record, StatusCode::OK, served.generation, "image/png", drawing.into()))
        }
        (_, Format::Json) if parameters.explained => {
            let explained = Explained::new(&found, index, served.generation).map_err(|_| Problem::lost())?;
            let status = record.status();
            let body = json_line(&ExplainedRecord { record, explained })?;
            Ok(send_with(status, StatusCode::OK, served.generation, "application/json", body))
        }
        _ => render(&record, format, StatusCode::OK, served.generation),
    }
}

/// MoveIt's message of a strategy, or why there is none.
fn grasp_message(record: &Record, answer: &Answer, generation: u64) -> Response {
    match moveit::message(answer) {
        Some(yaml) => send(record, StatusCode::OK, generation, "application/yaml", yaml.into()),
        None => {
            let why = moveit::refusal(answer).unwrap_or_else(|| human::text(record));
            let status = StatusCode::UNPROCESSABLE_ENTITY;
            send(record, status, generation, "text/plain; charset=utf-8", why.into())
        }
    }
}

/// The status of a picture that has no answer.
fn status_of(error: &RecogniseError) -> StatusCode {
    match error {
        RecogniseError::NoHand | RecogniseError::Empty(_) | RecogniseError::Hand(_) => {
            StatusCode::UNPROCESSABLE_ENTITY
        }
        RecogniseError::Decode(_) | RecogniseError::Source(_) | RecogniseError::Search(_) => {
            StatusCode::BAD_REQUEST
        }
    }
}

/// A record as a line of JSON or as text; in place of a drawing that cannot be made, as JSON.
fn render(record: &Record, format: Format, status: StatusCode, generation: u64) -> Result<Response, Problem> {
    Ok(match format {
        Format::Text | Format::Moveit => {
            send(record, status, generation, "text/plain; charset=utf-8", human::text(record).into())
        }
        Format::Json | Format::Drawing => {
            send(record, status, generation, "application/json", json_line(record)?)
        }
    })
}

fn json_line(value: &impl Serialize) -> Result<Bytes, Problem> {
    let mut line = serde_json::to_vec(value).map_err(|_| Problem::lost())?;
    line.push(b'\n');
    Ok(line.into())
}

fn send(record: &Record, status: StatusCode, generation: u64, kind: &'static str, body: Bytes) -> Response {
    send_with(record.status(), status, generation, kind, body)
}

fn send_with(exit: u8, status: StatusCode, generation: u64, kind: &'static str, body: Bytes) -> Response {
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(kind)),
        (STATUS, HeaderValue::from(u16::from(exit))),
        (GENERATION, HeaderValue::from(generation)),
    ];
    (status, headers, body).into_response()
}
