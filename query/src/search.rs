//! Raw descriptors, many at a time: searched on every core, timed as a whole.

use std::time::{Duration, Instant};

use grasp_index::{Neighbour, SearchCost, SearchError, SearchOptions, Segments, SegmentsSearcher};
use rayon::prelude::*;
use serde::Serialize;

/// Queries whose cost is looked at; a thousand give the mean as well as all do.
const SAMPLE: usize = 1000;

/// Queries on their way through an index, or several as one, in as many parts as threads search
/// them. Answers do not depend on the parts.
#[derive(Debug)]
pub struct Batch<'a> {
    options: SearchOptions,
    parts: Vec<Part<'a>>,
}

/// What one thread searches for, and has found.
#[derive(Debug)]
struct Part<'a> {
    queries: &'a [f32],
    searcher: SegmentsSearcher<'a>,
    found: Vec<Neighbour>,
}

/// Answers do not fit into memory.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("{0} neighbours do not fit into memory: search fewer queries at a time, or lower --k")]
pub struct TooMany(u128);

impl<'a> Batch<'a> {
    /// `queries` in rows of the indexes' dimension, for `threads` threads.
    ///
    /// # Errors
    /// [`TooMany`], where there is no memory for all neighbours.
    pub fn new(
        segments: &'a Segments,
        queries: &'a [f32],
        options: SearchOptions,
        threads: usize,
    ) -> Result<Self, TooMany> {
        let dim = segments.dim().max(1);
        let rows = (queries.len() / dim).div_ceil(threads.max(1)).max(1);
        let part = |queries: &'a [f32]| {
            let wanted = (queries.len() / dim).saturating_mul(options.k);
            let mut found = Vec::new();
            found.try_reserve_exact(wanted).map_err(|_| TooMany(wanted as u128))?;
            Ok(Part { queries, searcher: segments.searcher(), found })
        };
        Ok(Self { options, parts: queries.chunks(rows * dim).map(part).collect::<Result<_, _>>()? })
    }

    /// Searches for all queries and returns how long that took.
    ///
    /// # Errors
    /// [`SearchError`], where a query does not fit the index.
    pub fn run(&mut self) -> Result<Duration, SearchError> {
        let options = self.options;
        let search = |part: &mut Part<'_>| {
            part.found.clear();
            part.searcher.batch(part.queries, &options, &mut part.found)
        };
        let started = Instant::now();
        match self.parts.as_mut_slice() {
            // A pool of threads would take longer to start than a single query to answer.
            [single] => search(single)?,
            several => several.par_iter_mut().try_for_each(search)?,
        }
        Ok(started.elapsed())
    }

    /// How many threads search.
    pub fn threads(&self) -> usize {
        self.parts.len()
    }

    /// The neighbours of each query, k of them; missing ones have the id `u32::MAX`.
    pub fn found(&self) -> impl Iterator<Item = &[Neighbour]> {
        let k = self.options.k.max(1);
        self.parts.iter().flat_map(move |part| part.found.chunks_exact(k))
    }
}

/// What a query costs, on average.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeanCost {
    /// The recall that was measured at this effort when the index was built; null where that is
    /// unknown.
    pub predicted_recall: Option<f64>,
    /// Entries that were looked at.
    pub candidates: f64,
    /// The same as a share of the index, 0..=1.
    pub share_of_database: f64,
    /// Whether every entry was measured, for every query.
    pub exact: bool,
    /// The effort itself.
    pub effort: EffortRecord,
}

/// How hard was looked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EffortRecord {
    /// Buckets that were looked into, over all tables.
    pub probes: f64,
    /// Candidates whose distance was measured by the original descriptors.
    pub rerank: f64,
}

/// The mean cost of some of the queries, evenly spread over them: a search tells its cost, a batch
/// does not.
///
/// # Errors
/// [`SearchError`], where a query does not fit the index.
pub fn mean_cost(
    segments: &Segments,
    queries: &[f32],
    options: &SearchOptions,
) -> Result<MeanCost, SearchError> {
    let dim = segments.dim().max(1);
    let step = (queries.len() / dim).div_ceil(SAMPLE).max(1);
    let mut searcher = segments.searcher();
    let mut costs: Vec<SearchCost> = Vec::new();
    for query in queries.chunks_exact(dim).step_by(step) {
        let cost = searcher.search(query, options)?.cost;
        costs.push(cost);
        // Comparing with every entry takes long, and costs the same for every query.
        if cost.exact && !cost.fell_back {
            break;
        }
    }
    let mean =
        |value: fn(&SearchCost) -> f64| costs.iter().map(value).sum::<f64>() / costs.len().max(1) as f64;
    Ok(MeanCost {
        predicted_recall: costs
            .iter()
            .find(|cost| !cost.fell_back)
            .or(costs.first())
            .and_then(|cost| cost.predicted_recall),
        candidates: mean(|cost| f64::from(cost.candidates)),
        share_of_database: mean(|cost| cost.share_of_database),
        exact: costs.iter().all(|cost| cost.exact),
        effort: EffortRecord {
            probes: mean(|cost| f64::from(cost.buckets)),
            rerank: mean(|cost| f64::from(cost.reranked)),
        },
    })
}

/// The middle one of some durations, as nanoseconds a query; of an even number, the lower.
pub fn median_ns(rounds: &[Duration], queries: usize) -> f64 {
    let mut rounds = rounds.to_vec();
    rounds.sort_unstable();
    let middle = rounds.get(rounds.len().saturating_sub(1) / 2).copied().unwrap_or_default();
    ns_per_query(middle, queries)
}

/// A duration as nanoseconds a query.
pub fn ns_per_query(round: Duration, queries: usize) -> f64 {
    round.as_nanos() as f64 / queries.max(1) as f64
}
