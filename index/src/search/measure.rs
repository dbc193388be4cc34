//! What searches with more and more effort find of the neighbours of queries that an index has not
//! seen.

use super::distance;
use super::effort::{EPS_GRID, EffortPoint, Measured, RECALL_K};
use super::hash::{Hash, Located};
use super::in_flight::InFlight;
use super::nearest::Neighbour;
use super::queries::{HeldOut, Query, is_near_enough, queries};
use super::rows::{Rows, Source};
use super::simd::Simd;
use super::stored::Stored;
use rayon::prelude::*;

/// More effort than this finds is not measured.
const ENOUGH: f64 = 0.9995;
/// A small index may find no more with two buckets than with one, and yet with four.
const LEAST_LADDER: u32 = 16;

/// Searches for the queries with more and more probes, until nearly all is found.
fn curve<E>(
    rows: Rows<'_>,
    stored: Stored<'_>,
    hash: &Hash<'_>,
    queries: &[Query],
    progress: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Vec<EffortPoint>, E> {
    // With many tables it is this that takes the time, and every step needs the same.
    let locate = |in_flight: &mut InFlight<'_>, query: &Query| {
        in_flight.lookup.locate(Simd::best(), &query.vector);
        in_flight.lookup.located()
    };
    let located: Vec<Located> = queries.par_iter().map_init(|| InFlight::new(hash), locate).collect();
    let mut curve: Vec<EffortPoint> = Vec::new();
    let steps = ladder(hash.most_probes()).count();
    for (at, probes) in ladder(hash.most_probes()).enumerate() {
        progress(at as f64 / steps as f64)?;
        let point = point(rows, stored, hash, queries, &located, probes);
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

/// 1, 2, 3, ... 15, 16, 18, 20, ... 30, 32, 36, ... and last `most`: a search is asked for a
/// recall, and makes at most an eighth more effort than gives it.
fn ladder(most: u32) -> impl Iterator<Item = u32> {
    let steps = (0..).flat_map(|octave: u32| (8..16).map(move |eighth| (eighth << octave) / 8));
    let mut last = 0;
    let steps = steps
        .take_while(move |&step| step < most)
        .filter(move |&step| std::mem::replace(&mut last, step) != step);
    steps.chain([most])
}

fn point(
    rows: Rows<'_>,
    stored: Stored<'_>,
    hash: &Hash<'_>,
    queries: &[Query],
    located: &[Located],
    probes: u32,
) -> EffortPoint {
    let each: Vec<(f64, [f64; EPS_GRID.len()], f64)> = queries
        .par_iter()
        .zip(located)
        .map_init(
            || InFlight::new(hash),
            |in_flight, (query, located)| {
                in_flight.lookup.resume(located);
                // One more, because the query's own row is among them.
                let found =
                    in_flight.search_located(stored, Simd::best(), &query.vector, RECALL_K + 1, probes);
                let others = found.neighbours.iter().filter(|found| Some(found.id) != query.itself);
                // The distance that a search returns may be an estimate.
                let measured = |other: &Neighbour| {
                    let row = rows.get(other.id)?;
                    Some(Neighbour { distance: distance::squared(&query.vector, row).sqrt(), ..*other })
                };
                let others: Vec<Neighbour> = others.take(RECALL_K).filter_map(measured).collect();
                let nearest = &query.nearest[..query.nearest.len().min(RECALL_K)];
                let last = nearest.last().map_or(0.0, |last| last.distance);
                let right = others.iter().filter(|other| other.distance <= last).count().min(nearest.len());
                // An entry that is alone has no neighbours, and a search finds all of them.
                let is_alone = nearest.is_empty();
                let recall = if is_alone { 1.0 } else { right as f64 / nearest.len() as f64 };
                let success = EPS_GRID.map(|eps| {
                    let is_near = |first| is_near_enough(first, nearest, eps);
                    f64::from(u8::from(is_alone || others.first().is_some_and(is_near)))
                });
                (recall, success, found.cost.share_of_database)
            },
        )
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

/// Measures a hash, as it searches an index that keeps what `stored` does, on queries that it was
/// not chosen by. `progress` hears what share of that is done, and stops it by an error.
pub(crate) fn measure<E>(
    source: Source<'_>,
    stored: Stored<'_>,
    held_out: HeldOut<'_>,
    hash: &Hash<'_>,
    sigma: f64,
    seed: u64,
    progress: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Measured, E> {
    let half = |from: f64| move |done: f64| progress(from + done / 2.0);
    let queries = queries(source, held_out, sigma, RECALL_K, seed, 2, &half(0.0))?;
    source.will_jump();
    let curve = curve(source.rows, stored, hash, &queries, &half(0.5))?;
    source.will_pass();
    Ok(Measured {
        queries: queries.len() as u32,
        held_out: !held_out.is_empty(),
        noise: held_out.noise_of_queries(),
        curve,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ladder_ends_with_the_most() {
        let ladder = |most| ladder(most).collect::<Vec<_>>();
        assert_eq!(ladder(1), [1]);
        assert_eq!(ladder(3), [1, 2, 3]);
        assert_eq!(ladder(21), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 18, 20, 21]);
        assert!(ladder(500).windows(2).all(|steps| steps[0] < 8 || 8 * (steps[1] - steps[0]) <= steps[0]));
    }
}
