//! How many hyperplanes and tables: learned from the data for eps and a wanted success rate, as the paper has it, and
//! then measured.

use super::random::{self, RandomHash, RandomHyperplanes};
use super::tables::Tables;
use super::{Hash, Neighbour, Rows, distance, exact, tables};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rkyv::{Archive, Deserialize, Serialize};

/// The paper's eps.
pub const EPS: f64 = 0.05;
/// The share of queries whose nearest found shall be within `1 + EPS` of the true nearest: 0.95 is wanted, and a little
/// more aimed at, so that the measurement, on other queries, comes out above it.
const AIM: f64 = 0.965;
const QUERIES: usize = 400;
const MAX_TABLES: u32 = 48;
const MAX_PLANES: u32 = 24;
/// Rows that stand for all while the share of the database is estimated.
const SAMPLE: usize = 2_000;
/// The length of the step that makes a query of a row, in units of sigma. With 0.3, what is measured here (eps-success 0.97)
/// came true on 468 pictures of a hand that another program had rendered (0.97, at a share of 0.17); with noise that is
/// even in all directions it did not (0.97 measured, 0.88 true).
const STEP: f64 = 0.3;
/// Neighbours that recall is measured over.
const RECALL_K: usize = 10;
/// The most true neighbours of a query that are known: any of them within `1 + EPS` of the nearest makes a success.
const TRUE_NEIGHBOURS: usize = 64;

/// How the hash of an index is sized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HashParams {
    /// K and T are learned from the data: the cheapest that reach eps-success 0.95 at eps 0.05 on held-out rows.
    #[default]
    Auto,
    /// K, T and H as given.
    Fixed {
        /// The paper's K: hyperplanes a table, 1 to 64.
        k: u32,
        /// The paper's T: tables, 1 to 1024.
        t: u32,
        /// The paper's H: buckets a table, 1 to 2^20.
        buckets: u32,
    },
}

/// How well the hash does on rows of the index, each held out and disturbed.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// How many queries were measured.
    pub queries: u32,
    /// How far a held-out row is moved to make a query, in units of sigma.
    pub noise: f64,
    /// The eps of eps-success.
    pub eps: f64,
    /// The share of queries whose nearest found is within `1 + eps` of the true nearest.
    pub eps_success: f64,
    /// The share of the true 10 nearest that is found.
    pub recall_at_10: f64,
    /// The mean share of the database whose distance a query measures.
    pub share_of_database: f64,
}

/// A row that was taken for a query: moved a step, and not counted as an answer itself.
struct Query {
    row: u32,
    vector: Vec<f32>,
    /// The true nearest, without `row`.
    nearest: Vec<Neighbour>,
}

/// Draws queries from the rows. `stream` tells one set from another.
fn draw_queries(rows: Rows<'_>, sigma: f64, seed: u64, stream: u64) -> Vec<Query> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The tables' streams count up from 1: these stay clear of them.
    rng.set_stream(u64::MAX - stream);
    let mut draw = || rng.random_range(0..rows.len() as u64) as u32;
    let drawn: Vec<[u32; 3]> = (0..QUERIES.min(rows.len())).map(|_| [draw(), draw(), draw()]).collect();
    drawn
        .into_par_iter()
        .filter_map(|[row, from, to]| {
            // The difference of two rows: a direction in which the data varies, as one hand varies from another.
            let step: Vec<f32> = rows.get(from)?.iter().zip(rows.get(to)?).map(|(a, b)| b - a).collect();
            let length = distance::dot(&step, &step).sqrt().max(f32::MIN_POSITIVE);
            let scale = (STEP * sigma) as f32 / length;
            let vector: Vec<f32> =
                rows.get(row)?.iter().zip(&step).map(|(value, step)| value + scale * step).collect();
            let nearest = exact::nearest(rows, &vector, TRUE_NEIGHBOURS, Some(row));
            Some(Query { row, vector, nearest })
        })
        .collect()
}

/// The buckets of a table: about as many as rows.
fn buckets_for(rows: usize) -> u32 {
    (rows.min(1 << 20) as u32).next_power_of_two().max(16)
}

/// Chooses K and T: of all that reach the wanted success, the pair that measures the fewest distances and products.
pub(crate) fn choose(rows: Rows<'_>, sigma: f64, seed: u64) -> RandomHash {
    let queries = draw_queries(rows, sigma, seed, 1);
    let (normals, offsets) = random::draw(rows, MAX_TABLES, MAX_PLANES, seed);
    let all = RandomHash { planes: MAX_PLANES, tables: MAX_TABLES, buckets: 1, probes: 1 };
    let hash = RandomHyperplanes { size: all, dim: rows.dim, normals: &normals, offsets: &offsets };
    let sampled = rows.len().min(SAMPLE);
    let signature =
        |vector: &[f32]| -> Vec<u64> { (0..MAX_TABLES).map(|table| hash.bits(vector, table)).collect() };
    let sample: Vec<Vec<u64>> = (0..sampled)
        .into_par_iter()
        .filter_map(|at| rows.get((at * rows.len() / sampled) as u32).map(signature))
        .collect();
    let reach: Vec<Reach> = queries
        .par_iter()
        .map(|query| {
            let own = signature(&query.vector);
            let good = query.nearest.iter().filter(|n| is_near_enough(n, &query.nearest));
            let good: Vec<Vec<u64>> = good.filter_map(|n| rows.get(n.id).map(signature)).collect();
            Reach::of(&own, &good, &sample)
        })
        .collect();
    let cost = |planes: u32, tables: u32| {
        let (success, share) = totals(&reach, planes, tables);
        (success, share * rows.len() as f64 + f64::from(planes * tables))
    };
    let sizes = (1..=MAX_PLANES).flat_map(|planes| (1..=MAX_TABLES).map(move |tables| (planes, tables)));
    let good_enough = sizes.map(|(planes, tables)| (cost(planes, tables), planes, tables));
    let cheapest = good_enough
        .filter(|((success, _), ..)| *success >= AIM)
        .min_by(|((_, a), ..), ((_, b), ..)| a.total_cmp(b));
    let (planes, tables) = cheapest.map_or((1, MAX_TABLES), |(_, planes, tables)| (planes, tables));
    RandomHash { planes, tables, buckets: buckets_for(rows.len()), probes: 1 }
}

/// Whether a neighbour is within `1 + EPS` of the nearest.
fn is_near_enough(neighbour: &Neighbour, nearest: &[Neighbour]) -> bool {
    nearest
        .first()
        .is_some_and(|first| f64::from(neighbour.distance) <= (1.0 + EPS) * f64::from(first.distance))
}

/// What one query reaches with the first K planes of the first T tables, for every K and T at once: rows that agree
/// with the query on the first K bits of a table do so on any fewer.
struct Reach {
    /// For each table, the bits on which some good row agrees in this table or one before.
    good: Vec<u32>,
    /// For each table and number of bits, how many rows agree on exactly so many in this table or, more, in one before.
    agreeing: Vec<[u32; MAX_PLANES as usize + 1]>,
    rows: usize,
}

impl Reach {
    fn of(own: &[u64], good: &[Vec<u64>], rows: &[Vec<u64>]) -> Self {
        let common = |a: u64, b: u64| (a ^ b).trailing_zeros().min(MAX_PLANES);
        let mut best_good = 0;
        let mut best = vec![0u32; rows.len()];
        let mut reach = Self { good: Vec::new(), agreeing: Vec::new(), rows: rows.len() };
        for (table, &bits) in own.iter().enumerate() {
            best_good = good.iter().map(|row| common(bits, row[table])).fold(best_good, u32::max);
            let mut counts = [0; MAX_PLANES as usize + 1];
            for (best, row) in best.iter_mut().zip(rows) {
                *best = (*best).max(common(bits, row[table]));
                counts[*best as usize] += 1;
            }
            reach.good.push(best_good);
            reach.agreeing.push(counts);
        }
        reach
    }
}

/// Mean success and share of the database over all queries.
fn totals(reach: &[Reach], planes: u32, tables: u32) -> (f64, f64) {
    let (mut found, mut share) = (0.0, 0.0);
    for reach in reach {
        found += f64::from(u8::from(reach.good[tables as usize - 1] >= planes));
        let met: u32 = reach.agreeing[tables as usize - 1][planes as usize..].iter().sum();
        share += f64::from(met) / reach.rows as f64;
    }
    (found / reach.len() as f64, share / reach.len() as f64)
}

/// Measures a hash and its tables on queries that it was not chosen by.
pub(crate) fn measure(
    rows: Rows<'_>,
    hash: &dyn Hash,
    built: &Tables,
    probes: u32,
    sigma: f64,
    seed: u64,
) -> Measured {
    let queries = draw_queries(rows, sigma, seed, 2);
    let each: Vec<(bool, f64, f64)> = queries
        .par_iter()
        .map(|query| {
            let mut probed = Vec::new();
            hash.probe(&query.vector, probes, &mut probed);
            let mut met = tables::union(built.as_buckets(), &probed, rows.len());
            let share = met.len() as f64 / rows.len() as f64;
            met.retain(|&id| id != query.row);
            met.sort_unstable();
            let found = |neighbour: &&Neighbour| met.binary_search(&neighbour.id).is_ok();
            let success =
                query.nearest.iter().filter(|n| is_near_enough(n, &query.nearest)).any(|n| found(&n));
            let nearest = &query.nearest[..query.nearest.len().min(RECALL_K)];
            let recall = nearest.iter().filter(found).count() as f64 / nearest.len().max(1) as f64;
            (success, recall, share)
        })
        .collect();
    let mean =
        |value: fn(&(bool, f64, f64)) -> f64| each.iter().map(value).sum::<f64>() / each.len().max(1) as f64;
    Measured {
        queries: each.len() as u32,
        noise: STEP,
        eps: EPS,
        eps_success: mean(|(success, ..)| f64::from(u8::from(*success))),
        recall_at_10: mean(|(_, recall, _)| *recall),
        share_of_database: mean(|(.., share)| *share),
    }
}
