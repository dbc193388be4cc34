//! Queries that an index has not seen.

use super::distance;
use super::exact::{Threads, nearest_of_many};
use super::nearest::Neighbour;
use super::rows::{Rows, Source};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far a query is moved from the descriptor that it is made from, in units of sigma: least and
/// most. Descriptors of hand shapes that an index does not know lie a third as far from their
/// nearest neighbours as those of real pictures do, when both come from one renderer; moved so,
/// they lie as far (on 468 pictures of a hand of another program, of which the middle 80 % have
/// their nearest of 540,000 entries at 0.17 to 0.39). A step goes along the difference of two
/// descriptors, a direction in which the data varies: noise that is even in all directions promised
/// 0.97 where 0.88 came true.
pub const NOISE: [f64; 2] = [0.2, 0.5];
const QUERIES: usize = 800;
/// Queries that the vote is calibrated by: more, for they cost no exact search.
pub(crate) const QUERIES_OF_THE_VOTE: usize = 2_000;

/// A query with its true nearest.
#[derive(Clone, Debug)]
pub(crate) struct Query {
    /// The row that it was made from, which does not count as an answer, if it is one of the index.
    pub(crate) itself: Option<u32>,
    pub(crate) vector: Vec<f32>,
    /// Nearest first.
    pub(crate) nearest: Vec<Neighbour>,
}

/// Rows from outside an index, to measure it by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldOut<'a> {
    pub(crate) rows: Rows<'a>,
    /// How far they are moved to be queries, in units of sigma: nothing where they are what will be
    /// searched for.
    pub(crate) noise: [f64; 2],
}

impl HeldOut<'_> {
    /// Whether there are none, so that the index's own rows stand in.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.len() == 0
    }

    /// How far queries are moved, in units of sigma.
    pub(crate) fn noise_of_queries(&self) -> [f64; 2] {
        if self.is_empty() { NOISE } else { self.noise }
    }
}

/// Draws queries from `held_out`, or, where that holds none, from the rows themselves, and finds
/// their `k` nearest. `stream` distinguishes one set from another. `progress` hears what share of
/// that is done, and stops it by an error.
pub(crate) fn queries<E>(
    source: Source<'_>,
    held_out: HeldOut<'_>,
    sigma: f64,
    k: usize,
    seed: u64,
    stream: u64,
    progress: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Vec<Query>, E> {
    let (rows, own, noise) = (source.rows, held_out.is_empty(), held_out.noise_of_queries());
    source.will_jump();
    let moved = moved(if own { rows } else { held_out.rows }, QUERIES, noise, sigma, seed, stream);
    source.will_pass();
    let vectors: Vec<f32> = moved.iter().flat_map(|(_, vector)| vector).copied().collect();
    // One more, because the row that a query was made from is among them.
    let wanted = (k + 1).min(rows.len());
    let mut found = Vec::new();
    nearest_of_many(rows.into(), &vectors, wanted, Threads::All, &mut found, &mut |done, _| progress(done))?;
    let query = |((row, vector), found): ((u32, Vec<f32>), &[Neighbour])| {
        let itself = own.then_some(row);
        let others = found.iter().filter(|near| Some(near.id) != itself);
        Query { itself, vector, nearest: others.take(k).copied().collect() }
    };
    Ok(moved.into_iter().zip(found.chunks_exact(wanted.max(1))).map(query).collect())
}

/// Draws `count` rows of `from`, or as many as it has, and moves them by `noise`, in units of
/// `sigma`. Each is returned with the row that it was made from.
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
            let [least, most] = noise;
            let length = if least < most { rng.random_range(least..most) } else { least } * sigma;
            Some((row, moved_along(from.get(row)?, from.get(start)?, from.get(end)?, length as f32)))
        })
        .collect()
}

/// `row`, moved by `length` in the direction from `start` to `end`, which are rows as well. Where
/// these are equal, or so near to each other that their distance is no number to divide `length`
/// by, there is no such direction, and the row stays as it is.
#[must_use]
pub fn moved_along(row: &[f32], start: &[f32], end: &[f32], length: f32) -> Vec<f32> {
    let step: Vec<f32> = start.iter().zip(end).map(|(start, end)| end - start).collect();
    let norm = distance::dot(&step, &step).sqrt();
    let scale = length / norm;
    let scale = if scale.is_finite() { scale } else { 0.0 };
    row.iter().zip(&step).map(|(value, step)| value + scale * step).collect()
}

/// Whether a neighbour is within `1 + eps` of the nearest.
pub(crate) fn is_near_enough(neighbour: &Neighbour, nearest: &[Neighbour], eps: f64) -> bool {
    nearest
        .first()
        .is_some_and(|first| f64::from(neighbour.distance) <= (1.0 + eps) * f64::from(first.distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_moved_as_far_as_it_shall_be_and_stays_where_there_is_no_direction() {
        let moved = moved_along(&[1.0, 2.0], &[0.0, 0.0], &[3.0, 4.0], 10.0);
        assert_eq!(moved, [7.0, 10.0]);
        // Of a length beyond 4, a division by the least float was not finite.
        assert_eq!(moved_along(&[1.0, 2.0], &[3.0, 4.0], &[3.0, 4.0], 1e6), [1.0, 2.0]);
        assert_eq!(moved_along(&[1.0, 2.0], &[0.0, 0.0], &[1e-22, 0.0], 1e17), [1.0, 2.0]);
    }
}
