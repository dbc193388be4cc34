//! One index: how long it takes to build, how large it is, and what a search finds at what cost.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use clap::ValueEnum;
use grasp_index::{
    BuildError, DescriptorParams, EPS, Effort, HashParams, Index, IndexParams, IndexWriter, KeptFields,
    Neighbour, NewEntry, RandomParams, SearchOptions,
};

use super::data::Prepared;
use super::table::Row;
use crate::interrupt::{self, Interrupted};

/// Neighbours that are searched for.
const K: usize = 10;
/// The share of queries for which a neighbour within `1 + EPS` of the nearest is wanted, as in the
/// paper.
const SUCCESS: f64 = 0.95;
/// Timed rounds over all queries: the median counts.
const ROUNDS: usize = 5;
/// No further round is begun after this.
const LONG_ENOUGH: Duration = Duration::from_secs(10);

/// A hash to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Hash {
    /// Hyperplanes fitted to the data.
    Learned,
    /// The paper's random hyperplanes.
    Random,
}

impl Hash {
    /// All of them.
    pub const ALL: [Hash; 2] = [Hash::Learned, Hash::Random];

    /// As in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Learned => "learned",
            Self::Random => "random",
        }
    }

    fn params(self) -> HashParams {
        match self {
            Self::Learned => HashParams::Learned,
            Self::Random => HashParams::Random(RandomParams::Auto),
        }
    }
}

/// The true K nearest of each query, a row each.
pub(super) type Truth = Vec<Neighbour>;

/// Builds an index at `path` and measures it with the queries. `truth` is filled by the first to
/// need it.
pub(super) fn measure(
    data: &Prepared,
    hash: Hash,
    seed: u64,
    path: &Path,
    truth: &mut Option<Truth>,
) -> anyhow::Result<Row> {
    let started = Instant::now();
    build(data, hash, seed, path)?;
    let build_s = started.elapsed().as_secs_f64();
    let index = Index::open(path)?;
    let (queries, dim) = (data.queries.as_slice(), index.dim().max(1));
    let truth = match truth {
        Some(truth) => truth,
        missing => missing.insert(exact(&index, queries)?),
    };
    let effort = Effort::Success { eps: EPS, success: SUCCESS };
    let options = SearchOptions { k: K, effort };

    // One thread: what a query costs is not to depend on how many cores there are.
    let mut searcher = index.searcher();
    let mut found = Vec::with_capacity(truth.len());
    let mut rounds = Vec::new();
    let begun = Instant::now();
    // The first round warms up.
    while rounds.len() <= ROUNDS && (rounds.len() < 2 || begun.elapsed() < LONG_ENOUGH) {
        interrupt::check()?;
        found.clear();
        let started = Instant::now();
        searcher.batch(queries, &options, &mut found)?;
        rounds.push(started.elapsed());
    }
    let count = (queries.len() / dim).max(1) as f64;
    let mut costs = Vec::new();
    for query in queries.chunks_exact(dim) {
        costs.push(searcher.search(query, &options)?.cost);
    }
    let (mut near_enough, mut true_neighbours) = (0, 0);
    for (found, truth) in found.chunks_exact(K).zip(truth.chunks_exact(K)) {
        let (Some(nearest), Some(farthest)) = (truth.first(), truth.last()) else {
            bail!("no query: nothing to measure");
        };
        let nearest_found = found.first().map_or(f32::INFINITY, |neighbour| neighbour.distance);
        near_enough += u32::from(f64::from(nearest_found) <= (1.0 + EPS) * f64::from(nearest.distance));
        // Of entries at the same distance, either is a true neighbour.
        true_neighbours += found.iter().filter(|found| found.distance <= farthest.distance).count();
    }
    let mean = |sum: f64| sum / count;
    Ok(Row {
        entries: index.len() as u64,
        build_s,
        threads: rayon::current_num_threads(),
        file_bytes: index.byte_len(),
        ns_per_query: median_ns(rounds.get(1..).unwrap_or_default()) / count,
        candidates: mean(costs.iter().map(|cost| f64::from(cost.candidates)).sum()),
        share_of_database: mean(costs.iter().map(|cost| cost.share_of_database).sum()),
        recall_at_10: mean(true_neighbours as f64 / K as f64),
        eps_success: mean(f64::from(near_enough)),
        predicted_recall: costs.first().and_then(|cost| cost.predicted_recall),
        ..Row::default()
    })
}

fn build(data: &Prepared, hash: Hash, seed: u64, path: &Path) -> anyhow::Result<()> {
    let params = IndexParams {
        descriptor: DescriptorParams::raw(u32::try_from(data.base.dim)?),
        kept: KeptFields::nothing(),
        held_out: data.held_out.clone(),
        hash: hash.params(),
        seed,
        ..IndexParams::default()
    };
    let mut writer = IndexWriter::create(path, params)?;
    data.base.each(|row| Ok(writer.push(NewEntry { descriptor: row.to_vec(), ..NewEntry::default() })?))?;
    match writer.finish(&|_, _| interrupt::flow()) {
        Err(BuildError::Stopped) => Err(Interrupted.into()),
        other => other.map(drop).with_context(|| format!("{} was not written", path.display())),
    }
}

/// The true neighbours, by comparing with every entry, on all threads.
fn exact(index: &Index, queries: &[f32]) -> anyhow::Result<Truth> {
    Ok(index.searcher().exact(queries, K, &|_| interrupt::flow())?.ok_or(Interrupted)?)
}

fn median_ns(rounds: &[Duration]) -> f64 {
    let mut rounds = rounds.to_vec();
    rounds.sort_unstable();
    rounds.get(rounds.len() / 2).map_or(0.0, |round| round.as_nanos() as f64)
}
