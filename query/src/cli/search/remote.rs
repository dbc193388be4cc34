//! `grasp-query search --server`: the same answers, by a service that is running.

use std::collections::HashMap;

use anyhow::{Context as _, ensure};
use grasp_index::Neighbour;
use grasp_index::npy::{NpyHeader, NpyType};
use serde::Deserialize;

use super::Search;
use grasp_serve::client::{Address, Client};
use grasp_serve::wire::MOST_NEIGHBOURS;
use grasp_serve::wire::parameters::SearchParameters;

/// The most bytes of queries that are sent at a time: as many as a service takes unless told
/// otherwise, with some to spare.
const MOST_BYTES: usize = 16_000_000;

/// What is wrong with an answer that has not a line for each query.
const NO_SERVICE: &str = "the answer is not that of a grasp-query service of this version";

/// What a service has found.
pub(super) struct Found {
    /// Rows of k, as [`grasp_index::Searcher::batch`] has them.
    pub(super) neighbours: Vec<Neighbour>,
    /// The class and the file of each entry, where the service knows them.
    names: HashMap<u32, (Option<String>, Option<String>)>,
}

/// A line of what a service says.
#[derive(Deserialize)]
struct Line {
    query: usize,
    neighbours: Vec<Near>,
}

#[derive(Deserialize)]
struct Near {
    id: u32,
    distance: f32,
    grasp: Option<String>,
    file: Option<String>,
}

impl Found {
    pub(super) fn names(&self, id: u32) -> (Option<&str>, Option<String>) {
        self.names.get(&id).map_or((None, None), |(grasp, file)| (grasp.as_deref(), file.clone()))
    }
}

impl Search {
    /// Asks for the neighbours of all queries, which are rows of `dim` values.
    pub(super) fn ask(&self, address: &Address, queries: &[f32], dim: usize) -> anyhow::Result<Found> {
        let token = self.token_file.as_deref().map(crate::cli::token::read).transpose()?;
        let client = Client::new(address.clone(), token);
        let parameters = SearchParameters::from_options(&self.options());
        let mut found = Found { neighbours: Vec::new(), names: HashMap::new() };
        let rows = (MOST_NEIGHBOURS / self.k).min(MOST_BYTES / (4 * dim.max(1))).max(1);
        for queries in queries.chunks(rows * dim.max(1)) {
            let rows = (queries.len() / dim.max(1)) as u64;
            let header = NpyHeader { element: NpyType::F32, rows, columns: dim as u64, offset: 0 };
            let mut body = header.to_bytes();
            body.extend(queries.iter().flat_map(|value| value.to_le_bytes()));
            let answer = client.search(&parameters, &body)?;
            let mut answered = 0;
            for line in answer.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()) {
                let line: Line = serde_json::from_slice(line).context(NO_SERVICE)?;
                ensure!(line.query == answered, NO_SERVICE);
                answered += 1;
                let end = found.neighbours.len() + self.k;
                for near in line.neighbours.into_iter().take(self.k) {
                    found.neighbours.push(Neighbour { id: near.id, distance: near.distance });
                    found.names.entry(near.id).or_insert((near.grasp, near.file));
                }
                found.neighbours.resize(end, Neighbour { id: u32::MAX, distance: f32::INFINITY });
            }
            ensure!(answered as u64 == rows, NO_SERVICE);
        }
        Ok(found)
    }
}
