//! `POST /v1/search`: raw descriptors in, neighbours out.

use axum::body::Bytes;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use grasp_index::npy::{NpyError, NpyHeader, NpyType};
use grasp_index::{Index, SearchError};
use serde::Serialize;

use super::current::Served;
use super::descriptors;
use super::problem::Problem;
use crate::wire::parameters::SearchParameters;
use crate::wire::{GENERATION, MOST_NEIGHBOURS};
use grasp_answer::found::{QueryRecord, ShortlistRecord, with_place};

/// How a file in NumPy's format begins.
const NPY: &[u8] = b"\x93NUMPY";

/// Searches for all descriptors of a body; runs on a thread that may block.
pub(super) fn answer(
    served: &Served,
    body: &Bytes,
    parameters: &SearchParameters,
) -> Result<Response, Problem> {
    let index = &served.index;
    let options = parameters.options()?;
    let queries = read(body, index)?;
    let dim = index.dim().max(1);
    let rows = queries.len() / dim;
    if rows.saturating_mul(options.k) > MOST_NEIGHBOURS {
        return Err(too_large(format!("{rows} queries for {} neighbours each", options.k)));
    }
    let mut lines = Vec::with_capacity(rows * options.k * 64);
    let mut searcher = index.searcher();
    if parameters.shortlist {
        let mut candidates = 0;
        for (at, query) in queries.chunks_exact(dim).enumerate() {
            let refused = |error| refused(&error, at, dim);
            let record = match searcher.shortlist(query, &options).map_err(refused)? {
                Some(shortlist) => ShortlistRecord::new(index, at, &shortlist),
                None => {
                    let found = searcher.search(query, &options).map_err(refused)?;
                    ShortlistRecord::exact(index, at, &found.neighbours)
                }
            };
            // How many there are is known only now.
            candidates += record.neighbours.len();
            if candidates > MOST_NEIGHBOURS {
                let queries = at + 1;
                return Err(too_large(format!("{queries} of {rows} queries with {candidates} candidates")));
            }
            put(&record, &mut lines)?;
        }
    } else {
        let mut found = Vec::with_capacity(rows * options.k);
        searcher.batch(&queries, &options, &mut found).map_err(|error| refused(&error, 0, dim))?;
        for (at, neighbours) in found.chunks_exact(options.k.max(1)).enumerate() {
            put(&QueryRecord::new(index, at, neighbours), &mut lines)?;
        }
    }
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("application/x-ndjson")),
        (GENERATION, HeaderValue::from(served.generation)),
    ];
    Ok((headers, lines).into_response())
}

fn too_large(asked: String) -> Problem {
    let why = format!("{asked}: a request is answered with at most {MOST_NEIGHBOURS} neighbours");
    Problem::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", why)
}

/// Adds a line.
fn put(record: &impl Serialize, lines: &mut Vec<u8>) -> Result<(), Problem> {
    serde_json::to_writer(&mut *lines, record).map_err(|_| Problem::lost())?;
    lines.push(b'\n');
    Ok(())
}

/// The values of all queries, row by row: told by the first bytes, NumPy's format or JSON.
fn read(body: &Bytes, index: &Index) -> Result<Vec<f32>, Problem> {
    let dim = index.dim();
    let values = if body.starts_with(NPY) {
        let wrong = |error: NpyError| Problem::bad_request(error.to_string());
        let mut rest: &[u8] = body;
        let header = NpyHeader::read(&mut rest, NpyType::F32).map_err(wrong)?;
        if header.columns != dim as u64 {
            return Err(wrong(NpyError::Columns { found: header.columns, expected: dim }));
        }
        header.read_values(&mut rest).map_err(wrong)?
    } else {
        descriptors::read(body, dim).map_err(|error| Problem::bad_request(error.to_string()))?
    };
    if values.is_empty() {
        return Err(Problem::bad_request("there is no descriptor to search for"));
    }
    Ok(values)
}

/// What is wrong with queries of `dim` values each, the first of which is that of row `first`.
fn refused(error: &SearchError, first: usize, dim: usize) -> Problem {
    let place = |at| format!("descriptors[{}][{}]", first + at / dim, at % dim);
    Problem::new(StatusCode::BAD_REQUEST, "search", with_place(error, place))
}
