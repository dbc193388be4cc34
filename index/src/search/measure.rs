//! Queries that an index has not seen, and what searches with more and more effort find of their neighbours.

use super::effort::{EPS_GRID, EffortPoint, Measured};
use super::exact::{Threads, nearest_of_many};
use super::searcher::{Scratch, hashed};
use super::simd::Simd;
use super::stored::Stored;
use super::{Hash, Neighbour, Rows, Source, distance};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// How far a query is moved from the descriptor that it is made from, in units of sigma: least and most. Descriptors of
/// hand shapes that an index does not know lie a third as far from their nearest neighbours as those of real pictures do, when both
/// come from one renderer; moved so, they lie as far (on 468 pictures of a hand of another program, of which the
/// middle 80 % have their nearest of 540,000 entries at 0.17 to 0.39). A step goes along the difference of two descriptors,
/// a direction in which the data varies: noise that is even in all directions promised 0.97 where 0.88 came true.
pub const NOISE: [f64; 2] = [0.2, 0.5];
const QUERIES: usize = 800;
/// Queries that the vote is calibrated by: more, for they cost no exact search.
pub(crate) const QUERIES_OF_THE_VOTE: usize = 2_000;
/// Neighbours that recall is measured over.
const RECALL_K: usize = 10;
/// More effort than this finds is not measured.
const ENOUGH: f64 = 0.9995;
/// A small index may find no more with two buckets than with one, and yet with four.
const LEAST_LADDER: u32 = 16;

/// A query with its true nearest.
#[derive(Clone, Debug)]
pub(crate) struct Query {
    /// The row that it was made from, which does not count as an answer, if it is one of the index.
    pub(crate) itself: Option<u32>,
    pub(crate) vector: Vec<f32>,
    /// Nearest first.
    pub(crate) nearest: Vec<Neighbour>,
}

/// Draws queries from `held_out`, or, where that holds none, from the rows themselves, and finds their `k` nearest. `stream`
/// tells one set from another. `go_on` hears what share of that is done, and stops it by an error.
pub(crate) fn queries<E>(
    source: Source<'_>,
    held_out: Rows<'_>,
    sigma: f64,
    k: usize,
    seed: u64,
    stream: u64,
    go_on: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Vec<Query>, E> {
    let (rows, own) = (source.rows, held_out.len() == 0);
    source.file.will_jump();
    let moved = moved(if own { rows } else { held_out }, QUERIES, NOISE, sigma, seed, stream);
    source.file.will_pass();
    let vectors: Vec<f32> = moved.iter().flat_map(|(_, vector)| vector).copied().collect();
    // One more, because the row that a query was made from is among them.
    let wanted = (k + 1).min(rows.len());
    let mut found = Vec::new();
    nearest_of_many(rows.into(), &vectors, wanted, Threads::All, &mut found, &mut |done, _| go_on(done))?;
    let query = |((row, vector), found): ((u32, Vec<f32>), &[Neighbour])| {
        let itself = own.then_some(row);
        let others = found.iter().filter(|near| Some(near.id) != itself);
        Query { itself, vector, nearest: others.take(k).copied().collect() }
    };
    Ok(moved.into_iter().zip(found.chunks_exact(wanted.max(1))).map(query).collect())
}

/// Draws `count` rows of `from`, or as many as it has, and moves them by `noise`, in units of `sigma`. Each is told with the row that it was made from.
pub(crate) fn moved(
    from: Rows<'_>,
    count: usize,
    noise: [f64; 2],
    sigma: f64,
    seed: u64,
    stream: u64,
) -> Vec<(u32, Vec<f32>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // The tables' streams count up from 1: these stay clear of them.
    rng.set_stream(u64::MAX - stream);
    (0..count.min(from.len()))
        .filter_map(|_| {
            let [row, start, end] = [(); 3].map(|()| rng.random_range(0..from.len() as u64) as u32);
            let length = rng.random_range(noise[0]..noise[1]) * sigma;
            Some((row, step(from.get(row)?, from.get(start)?, from.get(end)?, length as f32)))
        })
        .collect()
}

/// `row`, moved by `length` in the direction from `start` to `end`.
fn step(row: &[f32], start: &[f32], end: &[f32], length: f32) -> Vec<f32> {
    let step: Vec<f32> = start.iter().zip(end).map(|(start, end)| end - start).collect();
    let scale = length / distance::dot(&step, &step).sqrt().max(f32::MIN_POSITIVE);
    row.iter().zip(&step).map(|(value, step)| value + scale * step).collect()
}

/// Whether a neighbour is within `1 + eps` of the nearest.
pub(crate) fn is_near_enough(neighbour: &Neighbour, nearest: &[Neighbour], eps: f64) -> bool {
    nearest
        .first()
        .is_some_and(|first| f64::from(neighbour.distance) <= (1.0 + eps) * f64::from(first.distance))
}

/// Searches for the queries with more and more probes, until nearly all is found.
fn curve<E>(
    rows: Rows<'_>,
    stored: Stored<'_>,
    hash: &dyn Hash,
    queries: &[Query],
    go_on: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Vec<EffortPoint>, E> {
    let mut curve: Vec<EffortPoint> = Vec::new();
    let steps = ladder(hash.most_probes()).count();
    for (at, probes) in ladder(hash.most_probes()).enumerate() {
        go_on(at as f64 / steps as f64)?;
        let point = point(rows, stored, hash, queries, probes);
        curve.push(point);
        // Where twice the effort finds no more, nothing will.
        let half = curve.iter().rev().find(|half| half.probes <= probes / 2);
        let is_flat = half.is_some_and(|half| half.recall_at_10 == point.recall_at_10);
        if (point.recall_at_10 >= ENOUGH && point.eps_success[0] >= ENOUGH)
            || (is_flat && probes >= LEAST_LADDER)
        {
            break;
        }
    }
    Ok(curve)
}

/// 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, ... and last `most`.
fn ladder(most: u32) -> impl Iterator<Item = u32> {
    let steps = (0..).flat_map(|octave: u32| (4..8).map(move |quarter| (quarter << octave) / 4));
    let mut last = 0;
    let steps = steps
        .take_while(move |&step| step < most)
        .filter(move |&step| std::mem::replace(&mut last, step) != step);
    steps.chain([most])
}

fn point(rows: Rows<'_>, stored: Stored<'_>, hash: &dyn Hash, queries: &[Query], probes: u32) -> EffortPoint {
    let each: Vec<(f64, [f64; EPS_GRID.len()], f64)> = queries
        .par_iter()
        .map_init(Scratch::default, |scratch, query| {
            // One more, because the query's own row is among them.
            let found = hashed(stored, hash, Simd::best(), &query.vector, RECALL_K + 1, probes, scratch);
            let others = found.neighbours.iter().filter(|found| Some(found.id) != query.itself);
            // The distance that a search tells may be an estimate.
            let measured = |other: &Neighbour| {
                let row = rows.get(other.id)?;
                Some(Neighbour { distance: distance::squared(&query.vector, row).sqrt(), ..*other })
            };
            let others: Vec<Neighbour> = others.take(RECALL_K).filter_map(measured).collect();
            let nearest = &query.nearest[..query.nearest.len().min(RECALL_K)];
            let last = nearest.last().map_or(0.0, |last| last.distance);
            let recall = others.iter().filter(|other| other.distance <= last).count().min(nearest.len());
            let success = EPS_GRID.map(|eps| {
                let first = others.first();
                f64::from(u8::from(first.is_some_and(|first| is_near_enough(first, nearest, eps))))
            });
            (recall as f64 / nearest.len().max(1) as f64, success, found.cost.share_of_database)
        })
        .collect();
    let count = each.len().max(1) as f64;
    EffortPoint {
        probes,
        recall_at_10: each.iter().map(|(recall, ..)| recall).sum::<f64>() / count,
        eps_success: std::array::from_fn(|at| {
            each.iter().map(|(_, success, _)| success[at]).sum::<f64>() / count
        }),
        share_of_database: each.iter().map(|(.., share)| share).sum::<f64>() / count,
    }
}

/// Measures a hash, as it searches an index that keeps what `stored` does, on queries that it was not chosen by. `go_on` hears what share
/// of that is done, and stops it by an error.
pub(crate) fn measure<E>(
    source: Source<'_>,
    stored: Stored<'_>,
    held_out: Rows<'_>,
    hash: &dyn Hash,
    sigma: f64,
    seed: u64,
    go_on: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Measured, E> {
    let half = |from: f64| move |done: f64| go_on(from + done / 2.0);
    let queries = queries(source, held_out, sigma, RECALL_K, seed, 2, &half(0.0))?;
    source.file.will_jump();
    let curve = curve(source.rows, stored, hash, &queries, &half(0.5))?;
    source.file.will_pass();
    Ok(Measured { queries: queries.len() as u32, held_out: held_out.len() > 0, noise: NOISE, curve })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ladder_ends_with_the_most() {
        let ladder = |most| ladder(most).collect::<Vec<_>>();
        assert_eq!(ladder(1), [1]);
        assert_eq!(ladder(3), [1, 2, 3]);
        assert_eq!(ladder(21), [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 21]);
    }
}
