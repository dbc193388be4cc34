//! Many searches of one index.

use super::blocks::QuantisedQuery;
use super::effort::Measured;
use super::exact::{self, Nearest, Threads, append};
use super::simd::Simd;
use super::smallest::Smallest;
use super::stored::Stored;
use super::{Effort, Hash, Neighbour, Search, SearchCost, SearchError, SearchOptions, Shortlist, check};
use crate::file::bytes::Bytes;
use std::collections::HashMap;
use std::convert::Infallible;
use std::ops::ControlFlow;

/// Searches one index, query after query. Each thread has its own.
pub struct Searcher<'a> {
    stored: Stored<'a>,
    hash: Box<dyn Hash + 'a>,
    measured: &'a Measured,
    simd: Simd,
    scratch: [Scratch; STAGES],
    files: Vec<&'a Bytes>,
    /// Before the first search: what that one needs is read ahead.
    is_cold: bool,
}

/// Queries of a batch that are under way at once: while one waits for memory, the others are worked on.
const STAGES: usize = 3;

/// Memory that one search after another uses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// The query in the frame of a learned hash.
    pub(crate) coordinates: Vec<f32>,
    pub(crate) query: QuantisedQuery,
    pub(crate) nearest: Smallest,
    pub(crate) groups: Vec<u32>,
    /// What [`Hash::probe`] finds: the buckets to look into, the most promising first, each with what it adds to the scores
    /// of its entries.
    pub(crate) buckets: Vec<(f32, u32)>,
    pub(crate) found: Smallest,
    /// A bit for each entry that was met.
    pub(crate) met: Vec<u64>,
    /// What [`Hash::gather`] finds: the entries whose distance is to be measured.
    pub(crate) candidates: Vec<u32>,
    pub(crate) measured: Nearest,
    /// A descriptor whose values had to be widened.
    row: Vec<f32>,
}

impl std::fmt::Debug for Searcher<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Searcher of {} entries, {}", self.stored.entries, self.simd.name())
    }
}

impl<'a> Searcher<'a> {
    pub(crate) fn new(
        stored: Stored<'a>,
        hash: Box<dyn Hash + 'a>,
        measured: &'a Measured,
        files: Vec<&'a Bytes>,
        is_cold: bool,
    ) -> Self {
        Self { stored, hash, measured, simd: Simd::best(), scratch: Default::default(), files, is_cold }
    }

    /// The nearest neighbours of a descriptor.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn search(&mut self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        let dim = self.stored.dim;
        if query.len() != dim {
            return Err(SearchError::WrongLength { expected: dim, found: query.len() });
        }
        check(query, options)?;
        let Some((probes, predicted_recall)) = self.probes(options.effort)? else {
            let all = exhaustive(self.stored, &self.files, query, options.k, SearchCost::default());
            return all.ok_or(SearchError::NoOriginals);
        };
        self.warm(query, options.k, probes);
        let scratch = &mut self.scratch[0];
        let mut found = hashed(self.stored, &*self.hash, self.simd, query, options.k, probes, scratch);
        if !found.cost.exact {
            found.cost.predicted_recall = predicted_recall;
        }
        Ok(found)
    }

    /// The candidates of a search of this segment, for one who asks all segments of an index and puts their answers together; `None` where
    /// the search is exact, whose neighbours can be merged by distance. How much effort is enough is the same in all segments.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn shortlist(
        &mut self,
        query: &[f32],
        options: &SearchOptions,
    ) -> Result<Option<Shortlist>, SearchError> {
        let dim = self.stored.dim;
        if query.len() != dim {
            return Err(SearchError::WrongLength { expected: dim, found: query.len() });
        }
        check(query, options)?;
        let Some((probes, _)) = self.probes(options.effort)? else { return Ok(None) };
        self.warm(query, options.k, probes);
        let (hash, scratch) = (&*self.hash, &mut self.scratch[0]);
        hash.probe(self.simd, query, probes, scratch);
        hash.gather(self.simd, options.k, scratch);
        let mut keys = HashMap::new();
        let keep = hash.keys(scratch, &mut |key, id| {
            keys.insert(id, key);
        });
        rerank(self.stored, hash, self.simd, query, scratch.candidates.len(), scratch);
        let keyed = |near: Neighbour| (keys.get(&near.id).copied().unwrap_or_default(), near);
        let candidates = scratch.measured.neighbours().map(keyed).collect();
        Ok(Some(Shortlist { probes, most_probes: hash.most_probes(), keep, candidates }))
    }

    /// The nearest neighbours of many descriptors: `queries` holds them in rows of the index's `dim` values. To `found` is
    /// appended a row of `k` neighbours for each, nearest first; where the index has fewer entries, the rest of the row has
    /// the id `u32::MAX` and an infinite distance.
    ///
    /// # Errors
    /// [`SearchError`], when a query does not fit the index; nothing is appended then.
    pub fn batch(
        &mut self,
        queries: &[f32],
        options: &SearchOptions,
        found: &mut Vec<Neighbour>,
    ) -> Result<(), SearchError> {
        let (stored, dim) = (self.stored, self.stored.dim.max(1));
        let rest = queries.len() % dim;
        if rest != 0 {
            return Err(SearchError::WrongLength { expected: dim, found: rest });
        }
        check(queries, options)?;
        let k = options.k;
        let Some((probes, _)) = self.probes(options.effort)? else {
            let Ok(()) =
                exact::nearest_of_many(stored, queries, k, Threads::One, found, &mut ahead(&self.files));
            return Ok(());
        };
        let queries: Vec<&[f32]> = queries.chunks_exact(dim).collect();
        if let Some(first) = queries.first() {
            self.warm(first, k, probes);
        }
        let (hash, simd) = (&*self.hash, self.simd);
        // Each turn takes one query a step further at each of three stages, so that what a stage asks the memory for
        // has a whole turn to arrive.
        for turn in 0..queries.len() + STAGES - 1 {
            if let Some(query) = queries.get(turn) {
                let scratch = &mut self.scratch[turn % STAGES];
                hash.probe(simd, query, probes, scratch);
                hash.prefetch(scratch);
            }
            if let Some(at) = turn.checked_sub(1).filter(|&at| at < queries.len()) {
                let scratch = &mut self.scratch[at % STAGES];
                hash.gather(simd, k, scratch);
                stored.prefetch(&scratch.candidates);
            }
            if let Some((at, query)) = turn.checked_sub(2).and_then(|at| Some((at, *queries.get(at)?))) {
                let scratch = &mut self.scratch[at % STAGES];
                if scratch.candidates.len() < k.min(stored.entries) {
                    let more = hashed(stored, hash, simd, query, k, probes.saturating_mul(2), scratch);
                    append(more.neighbours.into_iter(), k, found);
                } else {
                    rerank(stored, hash, simd, query, k, scratch);
                    append(scratch.measured.neighbours(), k, found);
                }
            }
        }
        Ok(())
    }

    /// The true nearest neighbours of many descriptors, as [`Self::batch`] with [`Effort::Exact`] finds them, on all threads, which go
    /// through the index together. `go_on` hears what share of the work is done, 0 to 1, and stops it by breaking: then there is
    /// no answer.
    ///
    /// # Errors
    /// [`SearchError`], when a query does not fit the index.
    pub fn exact(
        &mut self,
        queries: &[f32],
        k: usize,
        go_on: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Option<Vec<Neighbour>>, SearchError> {
        let (stored, dim) = (self.stored, self.stored.dim.max(1));
        let rest = queries.len() % dim;
        if rest != 0 {
            return Err(SearchError::WrongLength { expected: dim, found: rest });
        }
        let options = SearchOptions { k, effort: Effort::Exact };
        check(queries, &options)?;
        self.probes(options.effort)?;
        let (mut found, mut announce) = (Vec::new(), ahead(&self.files));
        let mut before = |done: f64, to_come: &[(u32, Stored<'a>)]| {
            let Ok(()) = announce(done, to_come);
            if go_on(done).is_break() { Err(()) } else { Ok(()) }
        };
        let searched = exact::nearest_of_many(stored, queries, k, Threads::All, &mut found, &mut before);
        Ok(searched.is_ok().then_some(found))
    }

    /// Before the first search of a file: asks for all buckets at once, and then for all descriptors, where one after the
    /// other would wait for the disk as often.
    fn warm(&mut self, query: &[f32], k: usize, probes: u32) {
        if !std::mem::take(&mut self.is_cold) {
            return;
        }
        let files = &self.files;
        files.iter().for_each(|bytes| bytes.will_jump());
        // A file knows what is its own.
        let will_need = |part: &[u8]| files.iter().for_each(|bytes| bytes.will_need(part));
        let scratch = &mut self.scratch[0];
        self.hash.probe(self.simd, query, probes, scratch);
        self.hash.parts(scratch, &mut |part| will_need(part));
        self.hash.gather(self.simd, k, scratch);
        for &id in &scratch.candidates {
            will_need(self.stored.part(id));
        }
    }

    /// How many buckets to look into, and what that was measured to find; `None` for all entries.
    fn probes(&self, effort: Effort) -> Result<Option<(u32, Option<f64>)>, SearchError> {
        let point = match effort {
            Effort::Exact => None,
            Effort::Probes(probes) => {
                return Ok(Some((probes.max(1), self.measured.at(probes).map(|point| point.recall_at_10))));
            }
            Effort::Recall(_) | Effort::Success { .. } => self.measured.enough(effort),
        };
        match point {
            None if !self.stored.are_kept() => Err(SearchError::NoOriginals),
            point => Ok(point.map(|point| (point.probes, Some(point.recall_at_10)))),
        }
    }
}

/// Searches an index through `hash`: the path of every hash. The query fits the descriptors.
pub(crate) fn hashed(
    stored: Stored<'_>,
    hash: &dyn Hash,
    simd: Simd,
    query: &[f32],
    k: usize,
    probes: u32,
    scratch: &mut Scratch,
) -> Search {
    let wanted = k.min(stored.entries);
    let (mut probes, most) = (probes.max(1), hash.most_probes());
    loop {
        hash.probe(simd, query, probes, scratch);
        hash.gather(simd, k, scratch);
        if scratch.candidates.len() >= wanted || probes >= most {
            break;
        }
        // Small buckets, or a large k: more of them are cheaper than all entries.
        probes = probes.saturating_mul(2);
    }
    let held = hash.held(0, scratch);
    let cost = SearchCost {
        tables: hash.tables(),
        buckets: scratch.buckets.len() as u32,
        candidates: held,
        share_of_database: f64::from(held) / stored.entries.max(1) as f64,
        reranked: if stored.are_kept() { scratch.candidates.len() as u32 } else { 0 },
        ..SearchCost::default()
    };
    if scratch.candidates.len() < wanted
        && let Some(all) = exhaustive(stored, &[], query, k, SearchCost { fell_back: true, ..cost })
    {
        return all;
    }
    stored.prefetch(&scratch.candidates);
    rerank(stored, hash, simd, query, k, scratch);
    Search { neighbours: scratch.measured.neighbours().collect(), cost }
}

/// Measures every entry; `None` where no descriptors are kept.
pub(crate) fn exhaustive(
    stored: Stored<'_>,
    files: &[&Bytes],
    query: &[f32],
    k: usize,
    cost: SearchCost,
) -> Option<Search> {
    if !stored.are_kept() {
        return None;
    }
    let (mut neighbours, k) = (Vec::new(), k.min(stored.entries));
    let Ok(()) = exact::nearest_of_many(stored, query, k, Threads::One, &mut neighbours, &mut ahead(files));
    let found_all = SearchCost { share_of_database: 1.0, exact: true, predicted_recall: Some(1.0), ..cost };
    Some(Search { neighbours, cost: SearchCost { reranked: stored.entries as u32, ..found_all } })
}

/// Has the blocks that are to be looked at next read ahead, so that they come while the one before is looked at.
fn ahead<'a>(files: &[&Bytes]) -> impl FnMut(f64, &[(u32, Stored<'a>)]) -> Result<(), Infallible> {
    const BLOCKS: usize = 2;
    |_, to_come| {
        for (_, block) in to_come.iter().take(BLOCKS) {
            files.iter().for_each(|file| file.will_pass(block.bytes()));
        }
        Ok(())
    }
}

/// Measures the candidates' distances, by their descriptors where these are kept, and keeps the k nearest.
pub(crate) fn rerank(
    stored: Stored<'_>,
    hash: &dyn Hash,
    simd: Simd,
    query: &[f32],
    k: usize,
    scratch: &mut Scratch,
) {
    let mut nearest = std::mem::take(&mut scratch.measured);
    nearest.reset(k);
    if stored.are_kept() {
        stored.measure(simd, query, &scratch.candidates, &mut scratch.row, &mut nearest);
    } else {
        hash.estimate(scratch, &mut nearest);
    }
    scratch.measured = nearest;
}
