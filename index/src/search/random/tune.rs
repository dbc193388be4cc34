//! How many hyperplanes and tables: learned from the data for eps and a wanted success rate, as the
//! paper has it, and then measured.

use super::{RandomHash, RandomHyperplanes, draw};
use crate::search::effort::EPS;
use crate::search::queries::{HeldOut, is_near_enough, queries};
use crate::search::rows::Source;
use rayon::prelude::*;

/// The share of queries whose nearest found shall be within `1 + EPS` of the true nearest: 0.95 is
/// wanted, and a little more aimed at, so that the measurement, on other queries, comes out above
/// it.
const AIM: f64 = 0.965;
const MAX_TABLES: u32 = 48;
const MAX_PLANES: u32 = 24;
/// Rows that stand for all while the share of the database is estimated.
const SAMPLE: usize = 2_000;
/// The most true neighbours of a query that are known: any of them within `1 + EPS` of the nearest
/// makes a success.
const TRUE_NEIGHBOURS: usize = 64;

/// The buckets of a table: about as many as rows.
fn buckets_for(rows: usize) -> u32 {
    (rows.min(1 << 20) as u32).next_power_of_two().max(16)
}

/// Chooses K and T: of all that reach the wanted success, the pair that measures the fewest
/// distances and products. `progress` stops the work by an error.
pub(crate) fn choose<E>(
    source: Source<'_>,
    held_out: HeldOut<'_>,
    sigma: f64,
    seed: u64,
    progress: &dyn Fn(f64) -> Result<(), E>,
) -> Result<RandomHash, E> {
    let queries = queries(source, held_out, sigma, TRUE_NEIGHBOURS, seed, 1, progress)?;
    let rows = source.rows;
    source.will_jump();
    let (normals, offsets) = draw(rows, MAX_TABLES, MAX_PLANES, seed);
    let all = RandomHash { planes: MAX_PLANES, tables: MAX_TABLES, buckets: 1 };
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
            let good = query.nearest.iter().filter(|n| is_near_enough(n, &query.nearest, EPS));
            let good: Vec<Vec<u64>> = good.filter_map(|n| rows.get(n.id).map(signature)).collect();
            Reach::new(&own, &good, &sample)
        })
        .collect();
    source.will_pass();
    let cost = |planes: u32, tables: u32| {
        let (success, share) = totals(&reach, planes, tables);
        (success, share * rows.len() as f64 + f64::from(planes * tables))
    };
    // The places of ids are u32.
    let most = u32::try_from(u32::MAX as usize / rows.len().max(1)).unwrap_or(u32::MAX);
    let most = most.clamp(1, MAX_TABLES);
    let sizes = (1..=MAX_PLANES).flat_map(|planes| (1..=most).map(move |tables| (planes, tables)));
    let good_enough = sizes.map(|(planes, tables)| (cost(planes, tables), planes, tables));
    let cheapest = good_enough
        .filter(|((success, _), ..)| *success >= AIM)
        .min_by(|((_, a), ..), ((_, b), ..)| a.total_cmp(b));
    let (planes, tables) = cheapest.map_or((1, most), |(_, planes, tables)| (planes, tables));
    Ok(RandomHash { planes, tables, buckets: buckets_for(rows.len()) })
}

/// What one query reaches with the first K planes of the first T tables, for every K and T at once:
/// rows that agree with the query on the first K bits of a table do so on any fewer.
struct Reach {
    /// For each table, the bits on which some good row agrees in this table or one before.
    good: Vec<u32>,
    /// For each table and number of bits, how many rows agree on exactly so many in this table or,
    /// more, in one before.
    agreeing: Vec<[u32; MAX_PLANES as usize + 1]>,
    rows: usize,
}

impl Reach {
    fn new(own: &[u64], good: &[Vec<u64>], rows: &[Vec<u64>]) -> Self {
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
