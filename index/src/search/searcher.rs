//! Many searches of one index.

use super::effort::Measured;
use super::exact::{Threads, append, nearest_of_many};
use super::hash::Hash;
use super::in_flight::{InFlight, ahead, exhaustive};
use super::nearest::Neighbour;
use super::options::{Effort, SearchError, SearchOptions, check};
use super::read_ahead::ReadAhead;
use super::result::{Search, SearchCost, Shortlist};
use super::simd::Simd;
use super::stored::Stored;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Searches one index, query after query. Each thread has its own.
pub struct Searcher<'a> {
    stored: Stored<'a>,
    measured: &'a Measured,
    simd: Simd,
    in_flight: [InFlight<'a>; STAGES],
    files: Vec<&'a dyn ReadAhead>,
    /// Of each file, whether it has not been searched yet: what its first search needs is read
    /// ahead.
    is_cold: Vec<&'a AtomicBool>,
}

/// Queries of a batch that are under way at once: while one waits for memory, the others are worked
/// on.
const STAGES: usize = 3;

impl std::fmt::Debug for Searcher<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Searcher of {} entries, {}", self.stored.entries, self.simd.name())
    }
}

impl<'a> Searcher<'a> {
    pub(crate) fn new(
        stored: Stored<'a>,
        hash: &Hash<'a>,
        measured: &'a Measured,
        files: Vec<&'a dyn ReadAhead>,
        is_cold: Vec<&'a AtomicBool>,
    ) -> Self {
        let in_flight = std::array::from_fn(|_| InFlight::new(hash));
        Self { stored, measured, simd: Simd::best(), in_flight, files, is_cold }
    }

    /// The nearest neighbours of a descriptor.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn search(&mut self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        self.check_one(query, options)?;
        let Some((probes, predicted_recall)) = self.probes(options.effort)? else {
            let all = exhaustive(self.stored, &self.files, query, options.k, SearchCost::default());
            return all.ok_or(SearchError::NoOriginals);
        };
        self.warm(query, options.k, probes);
        let mut found = self.in_flight[0].search(self.stored, self.simd, query, options.k, probes);
        if !found.cost.exact {
            found.cost.predicted_recall = predicted_recall;
        }
        Ok(found)
    }

    /// The candidates of a search of this segment, for one who asks all segments of an index and
    /// puts their answers together; `None` where the search is exact, whose neighbours can be
    /// merged by distance. How much effort is enough is the same in all segments.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn shortlist(
        &mut self,
        query: &[f32],
        options: &SearchOptions,
    ) -> Result<Option<Shortlist>, SearchError> {
        self.check_one(query, options)?;
        let Some((probes, _)) = self.probes(options.effort)? else { return Ok(None) };
        self.warm(query, options.k, probes);
        let in_flight = &mut self.in_flight[0];
        in_flight.lookup.probe(self.simd, query, probes);
        in_flight.lookup.gather(self.simd, options.k);
        let (keep, keys) = in_flight.lookup.keys().unzip();
        let keys = keys.unwrap_or_default();
        in_flight.rerank(self.stored, self.simd, query, in_flight.lookup.shortlist().len());
        let keyed = |near: Neighbour| (keys.get(&near.id).copied().unwrap_or_default(), near);
        let candidates = in_flight.nearest.neighbours().map(keyed).collect();
        Ok(Some(Shortlist { probes, most_probes: in_flight.lookup.most_probes(), keep, candidates }))
    }

    /// The nearest neighbours of many descriptors: `queries` holds them in rows of the index's
    /// `dim` values. To `found` is appended a row of `k` neighbours for each, nearest first; where
    /// the index has fewer entries, the rest of the row has the id `u32::MAX` and an infinite
    /// distance.
    ///
    /// # Errors
    /// [`SearchError`], when a query does not fit the index; nothing is appended then.
    pub fn batch(
        &mut self,
        queries: &[f32],
        options: &SearchOptions,
        found: &mut Vec<Neighbour>,
    ) -> Result<(), SearchError> {
        let (stored, k) = (self.stored, options.k);
        reserve(found, k, self.check_many(queries, options)?)?;
        let Some((probes, _)) = self.probes(options.effort)? else {
            let Ok(()) = nearest_of_many(stored, queries, k, Threads::One, found, &mut ahead(&self.files));
            return Ok(());
        };
        let queries: Vec<&[f32]> = queries.chunks_exact(stored.dim.max(1)).collect();
        if let Some(first) = queries.first() {
            self.warm(first, k, probes);
        }
        let simd = self.simd;
        // Each turn takes one query a step further at each of three stages, so that what a stage
        // asks the memory for has a whole turn to arrive.
        for turn in 0..queries.len() + STAGES - 1 {
            if let Some(query) = queries.get(turn) {
                let lookup = &mut self.in_flight[turn % STAGES].lookup;
                lookup.probe(simd, query, probes);
                lookup.prefetch();
            }
            if let Some(at) = turn.checked_sub(1).filter(|&at| at < queries.len()) {
                let lookup = &mut self.in_flight[at % STAGES].lookup;
                lookup.gather(simd, k);
                stored.prefetch(lookup.shortlist());
            }
            if let Some((at, query)) = turn.checked_sub(2).and_then(|at| Some((at, *queries.get(at)?))) {
                let in_flight = &mut self.in_flight[at % STAGES];
                if in_flight.lookup.shortlist().len() < k.min(stored.entries) {
                    let more = in_flight.search(stored, simd, query, k, probes.saturating_mul(2));
                    append(more.neighbours.into_iter(), k, found);
                } else {
                    in_flight.rerank(stored, simd, query, k);
                    append(in_flight.nearest.neighbours(), k, found);
                }
            }
        }
        Ok(())
    }

    /// The true nearest neighbours of many descriptors, as [`Self::batch`] with [`Effort::Exact`]
    /// finds them, on all threads, which go through the index together. `progress` hears what share
    /// of the work is done, 0 to 1, and stops it by breaking: then there is no answer.
    ///
    /// # Errors
    /// [`SearchError`], when a query does not fit the index.
    pub fn exact(
        &mut self,
        queries: &[f32],
        k: usize,
        progress: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Option<Vec<Neighbour>>, SearchError> {
        let options = SearchOptions { k, effort: Effort::Exact };
        let count = self.check_many(queries, &options)?;
        self.probes(options.effort)?;
        let (mut found, mut announce) = (Vec::new(), ahead(&self.files));
        reserve(&mut found, k, count)?;
        let mut before = |done: f64, to_come: &[(u32, Stored<'a>)]| {
            let Ok(()) = announce(done, to_come);
            if progress(done).is_break() { Err(()) } else { Ok(()) }
        };
        let searched = nearest_of_many(self.stored, queries, k, Threads::All, &mut found, &mut before);
        Ok(searched.is_ok().then_some(found))
    }

    /// Checks a query and what is wanted of its search.
    fn check_one(&self, query: &[f32], options: &SearchOptions) -> Result<(), SearchError> {
        let dim = self.stored.dim;
        if query.len() != dim {
            return Err(SearchError::WrongLength { expected: dim, found: query.len() });
        }
        check(query, options)
    }

    /// The same of queries in rows; returns how many they are.
    fn check_many(&self, queries: &[f32], options: &SearchOptions) -> Result<usize, SearchError> {
        let dim = self.stored.dim.max(1);
        let rest = queries.len() % dim;
        if rest != 0 {
            return Err(SearchError::WrongLength { expected: dim, found: rest });
        }
        check(queries, options)?;
        Ok(queries.len() / dim)
    }

    /// Before the first search of a file: asks for all buckets at once, and then for all
    /// descriptors, where one after the other would wait for the disk as often.
    fn warm(&mut self, query: &[f32], k: usize, probes: u32) {
        // Each file's flag is taken: a searcher of another thread has not to do the same.
        let were_cold = self.is_cold.drain(..).filter(|is_cold| is_cold.swap(false, Ordering::Relaxed));
        if were_cold.count() == 0 {
            return;
        }
        let files = &self.files;
        files.iter().for_each(|bytes| bytes.will_jump());
        // A file knows what is its own.
        let will_need = |part: &[u8]| files.iter().for_each(|bytes| bytes.will_need(part));
        let lookup = &mut self.in_flight[0].lookup;
        lookup.probe(self.simd, query, probes);
        lookup.for_each_part(will_need);
        lookup.gather(self.simd, k);
        for &id in lookup.shortlist() {
            will_need(self.stored.part(id));
        }
    }

    /// How many buckets to look into, and what that was measured to find; `None` for all entries.
    fn probes(&self, effort: Effort) -> Result<Option<(u32, Option<f64>)>, SearchError> {
        let point = match effort {
            Effort::Exact => None,
            Effort::Probes(probes) => {
                return Ok(Some((probes, self.measured.at(probes).map(|point| point.recall_at_10))));
            }
            Effort::Recall(_) | Effort::Success { .. } => self.measured.enough(effort),
        };
        match point {
            None if !self.stored.are_kept() && effort == Effort::Exact => Err(SearchError::NoOriginals),
            None if !self.stored.are_kept() => {
                Err(SearchError::NotReached { best: self.measured.best_recall() })
            }
            point => Ok(point.map(|point| (point.probes, Some(point.recall_at_10)))),
        }
    }
}

/// Makes room for the `k` neighbours of so many queries.
///
/// # Errors
/// [`SearchError::TooManyNeighbours`], where there is not so much memory.
pub(crate) fn reserve(found: &mut Vec<Neighbour>, k: usize, queries: usize) -> Result<(), SearchError> {
    let room = queries.checked_mul(k).and_then(|count| found.try_reserve(count).ok());
    room.ok_or(SearchError::TooManyNeighbours { k, queries })
}
