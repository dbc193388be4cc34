//! The k nearest of the rows that are measured.

use super::nearest::{Nearest, Neighbour};
use super::simd::Simd;
use super::stored::Stored;
use rayon::prelude::*;

/// Bytes of values that are measured against one query after another while they are in the nearest
/// cache.
const TILE: usize = 32 << 10;
/// Bytes of values that all threads have measured before any goes on, so that they read a file
/// together: many tiles, and read in a fraction of a second.
const CHUNK: usize = 16 << 20;
/// Neighbours that are kept at a time, 32 MB of them: for more, the rows are gone through again.
const KEPT: usize = 4 << 20;

/// Who measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Threads {
    /// The calling thread, which may be one of many that each have queries of their own.
    One,
    /// All, each for its share of the queries.
    All,
}

/// What is done before a chunk is looked at.
pub(crate) type Before<'f, 'a, E> = dyn FnMut(f64, &[(u32, Stored<'a>)]) -> Result<(), E> + 'f;

/// The k nearest of all rows for each query. `queries` holds them in rows of the length of a stored
/// row; to `found` is appended a row of `k` neighbours for each, filled up as [`append`] does. The
/// rows are gone through once, in order, whatever the number of queries, unless these want more
/// neighbours than are kept at a time ([`KEPT`]). Before each chunk, `before` hears what share of
/// the work is done and which chunks are still to come, this one first; it stops the work by an
/// error.
pub(crate) fn nearest_of_many<'a, E>(
    stored: Stored<'a>,
    queries: &[f32],
    k: usize,
    threads: Threads,
    found: &mut Vec<Neighbour>,
    before: &mut Before<'_, 'a, E>,
) -> Result<(), E> {
    let (simd, dim) = (Simd::best(), stored.dim.max(1));
    let chunks = stored.chunks(CHUNK);
    let at_once = (KEPT / k.max(1)).max(1);
    let passes = (queries.len() / dim).div_ceil(at_once);
    for (pass, queries) in queries.chunks(at_once * dim).enumerate() {
        let mut nearest = vec![Nearest::new(k); queries.len() / dim];
        let mut to_come = &chunks[..];
        while let Some((&(first, chunk), rest)) = to_come.split_first() {
            let at = pass * chunks.len() + chunks.len() - to_come.len();
            before(at as f64 / (passes * chunks.len()) as f64, to_come)?;
            to_come = rest;
            match threads {
                Threads::One => scan(simd, first, chunk, queries, &mut nearest),
                Threads::All => {
                    let share = nearest.len().div_ceil(rayon::current_num_threads()).max(1);
                    let shares = nearest.par_chunks_mut(share).zip(queries.par_chunks(share * dim));
                    shares.for_each(|(nearest, queries)| scan(simd, first, chunk, queries, nearest));
                }
            }
        }
        nearest.iter_mut().for_each(|nearest| append(nearest.neighbours(), k, found));
    }
    Ok(())
}

/// Offers each row of a chunk, whose first has the number `first`, to the nearest of each query.
fn scan(simd: Simd, first: u32, chunk: Stored<'_>, queries: &[f32], nearest: &mut [Nearest]) {
    let mut widened = Vec::new();
    for (start, tile) in chunk.chunks(TILE) {
        let Some(values) = tile.widened(&mut widened) else { continue };
        let start = first.saturating_add(start);
        for (query, nearest) in queries.chunks_exact(chunk.dim).zip(&mut *nearest) {
            simd.distances(query, values.chunks_exact(chunk.dim), |at, squared| {
                nearest.offer(start.saturating_add(at as u32), squared);
            });
        }
    }
}

/// Appends a row of `k` neighbours. Where there are fewer, the rest has the id `u32::MAX` and an
/// infinite distance.
pub(crate) fn append(neighbours: impl Iterator<Item = Neighbour>, k: usize, found: &mut Vec<Neighbour>) {
    let end = found.len() + k;
    found.extend(neighbours);
    found.resize(end, Neighbour { id: u32::MAX, distance: f32::INFINITY });
}

#[cfg(test)]
mod tests {
    use super::super::distance;
    use super::super::rows::Rows;
    use super::super::stored::{Several, Values};
    use super::*;
    use half::f16;
    use half::slice::HalfFloatSliceExt as _;
    use proptest::prelude::*;
    use std::convert::Infallible;

    const NONE: Neighbour = Neighbour { id: u32::MAX, distance: f32::INFINITY };

    /// Each query by itself: all distances, sorted.
    fn one_by_one(rows: Rows<'_>, queries: &[f32], k: usize) -> Vec<Neighbour> {
        let mut found = Vec::new();
        for query in queries.chunks_exact(rows.dim) {
            let ids = 0..rows.len() as u32;
            let measured = |id| {
                let squared = distance::squared(query, rows.get(id).expect("there is such a row"));
                Neighbour { id, distance: if squared.is_nan() { f32::INFINITY } else { squared.sqrt() } }
            };
            let mut all: Vec<Neighbour> = ids.map(measured).collect();
            all.sort_by(Neighbour::by_distance);
            all.resize(all.len().max(k), NONE);
            found.extend(&all[..k]);
        }
        found
    }

    fn at_once(stored: Stored<'_>, queries: &[f32], k: usize, threads: Threads) -> Vec<Neighbour> {
        let mut found = Vec::new();
        let Ok(()) =
            nearest_of_many(stored, queries, k, threads, &mut found, &mut |_, _| Ok::<(), Infallible>(()));
        found
    }

    /// Two files.
    #[derive(Debug)]
    struct Two<'a>(Stored<'a>, Stored<'a>);

    impl Several for Two<'_> {
        fn locate(&self, id: u32) -> Option<(Stored<'_>, u32)> {
            Some(id.checked_sub(self.0.entries as u32).map_or((self.0, id), |id| (self.1, id)))
        }

        fn all(&self) -> Vec<(u32, Stored<'_>)> {
            vec![(0, self.0), (self.0.entries as u32, self.1)]
        }
    }

    proptest! {
        #[test]
        fn a_batch_finds_what_each_query_finds_to_the_bit(
            dim in 1..70usize, rows in 1..90usize, queries in 0..7usize, k in 1..100usize, seed: u64, grid: bool, split in 0..90usize,
        ) {
            let mut state = seed | 1;
            let mut draw = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                // On a grid, equal distances are frequent.
                if grid { (state >> 62) as f32 } else { (state >> 40) as f32 / 1e6 }
            };
            let halves: Vec<f16> = (0..rows * dim).map(|_| f16::from_f32(draw())).collect();
            let values = halves.to_f32_vec();
            let queries: Vec<f32> = (0..queries * dim).map(|_| draw()).collect();
            let of = |values, entries| Stored { dim, entries, values };
            let split = split.min(rows);
            let (first, second) = values.split_at(split * dim);
            let two = Two(of(Values::F32(first), split), of(Values::F16(&halves[split * dim..]), rows - split));
            let expected = one_by_one(Rows { values: &values, dim }, &queries, k);
            prop_assert_eq!(second.len(), (rows - split) * dim);
            for kept in [Values::F32(&values), Values::F16(&halves), Values::Several(&two)] {
                for threads in [Threads::One, Threads::All] {
                    prop_assert_eq!(&at_once(of(kept, rows), &queries, k, threads), &expected);
                }
            }
            prop_assert!(at_once(of(Values::None, rows), &queries, k, Threads::One).iter().all(|near| *near == NONE));
        }

        #[test]
        fn chunks_are_all_entries_in_order(dim in 1..9usize, entries in 0..50usize, bytes in 0..500usize) {
            let values: Vec<f32> = (0..dim * entries).map(|at| at as f32).collect();
            let stored = Stored { dim, entries, values: Values::F32(&values) };
            let mut all: Vec<f32> = Vec::new();
            for (first, chunk) in stored.chunks(bytes) {
                let mut widened = Vec::new();
                let values = chunk.widened(&mut widened).expect("one file");
                prop_assert_eq!((first as usize * dim, chunk.entries * dim), (all.len(), values.len()));
                prop_assert!(size_of_val(values) <= bytes.max(dim * size_of::<f32>()));
                prop_assert_eq!(chunk.bytes().len(), size_of_val(values));
                all.extend(values);
            }
            prop_assert_eq!(all, values);
        }
    }

    #[test]
    fn chunks_and_passes_make_one_search() {
        // More than a chunk, and not an integer number of tiles.
        let (dim, rows) = (1000, CHUNK / 4000 + 77);
        let values: Vec<f32> = (0..rows * dim).map(|at| ((at * 7919) % 1009) as f32).collect();
        let stored = Stored { dim, entries: rows, values: Values::F32(&values) };
        let queries: Vec<f32> = (0..3 * dim).map(|at| ((at * 31) % 1009) as f32).collect();
        let expected = one_by_one(Rows { values: &values, dim }, &queries, 20);
        let (mut found, mut heard) = (Vec::new(), Vec::new());
        let searched =
            nearest_of_many(stored, &queries, 20, Threads::All, &mut found, &mut |done, to_come| {
                heard.push((done, to_come.len()));
                Ok::<(), ()>(())
            });
        assert_eq!((searched, found), (Ok(()), expected));
        assert_eq!(heard, [(0.0, 2), (0.5, 1)]);

        // So many neighbours that each query has a pass of its own.
        let few = Stored { dim: 1, entries: 2, values: Values::F32(&[4.0, 1.0]) };
        let found = at_once(few, &[0.0, 5.0], KEPT, Threads::One);
        let ids: Vec<u32> = found.chunks(KEPT).flat_map(|row| [row[0].id, row[1].id, row[2].id]).collect();
        assert_eq!(ids, [1, 0, u32::MAX, 0, 1, u32::MAX]);

        let (mut found, mut calls) = (Vec::new(), 0);
        let stopped = nearest_of_many(stored, &queries, 20, Threads::One, &mut found, &mut |_, _| {
            calls += 1;
            if calls == 2 { Err("enough") } else { Ok(()) }
        });
        assert_eq!((stopped, found.len(), calls), (Err("enough"), 0, 2));
    }
}
