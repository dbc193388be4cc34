//! One search: the path that all hashes share.

use super::exact::{Threads, nearest_of_many};
use super::hash::{Hash, Lookup};
use super::nearest::Nearest;
use super::read_ahead::ReadAhead;
use super::result::{Search, SearchCost};
use super::simd::Simd;
use super::stored::Stored;
use std::convert::Infallible;

/// One query after another on its way from buckets to neighbours, with the memory that it takes.
#[derive(Clone, Debug)]
pub(crate) struct InFlight<'a> {
    pub(crate) lookup: Lookup<'a>,
    pub(crate) nearest: Nearest,
    /// A descriptor whose values had to be widened.
    row: Vec<f32>,
}

impl<'a> InFlight<'a> {
    pub(crate) fn new(hash: &Hash<'a>) -> Self {
        Self { lookup: Lookup::new(hash), nearest: Nearest::default(), row: Vec::new() }
    }

    /// Searches for a query that fits the descriptors.
    pub(crate) fn search(
        &mut self,
        stored: Stored<'_>,
        simd: Simd,
        query: &[f32],
        k: usize,
        probes: u32,
    ) -> Search {
        self.lookup.locate(simd, query);
        self.search_located(stored, simd, query, k, probes)
    }

    /// As [`Self::search`], for the query that was located last.
    pub(crate) fn search_located(
        &mut self,
        stored: Stored<'_>,
        simd: Simd,
        query: &[f32],
        k: usize,
        probes: u32,
    ) -> Search {
        let lookup = &mut self.lookup;
        let wanted = k.min(stored.entries);
        let (mut probes, most) = (probes.max(1), lookup.most_probes());
        loop {
            lookup.rank(simd, probes);
            lookup.gather(simd, k);
            if lookup.shortlist().len() >= wanted || probes >= most {
                break;
            }
            // Small buckets, or a large k: more of them are cheaper than all entries.
            probes = probes.saturating_mul(2);
        }
        let held = lookup.held();
        let cost = SearchCost {
            tables: lookup.tables(),
            buckets: lookup.buckets() as u32,
            candidates: held,
            share_of_database: f64::from(held) / stored.entries.max(1) as f64,
            reranked: if stored.are_kept() { lookup.shortlist().len() as u32 } else { 0 },
            ..SearchCost::default()
        };
        if lookup.shortlist().len() < wanted
            && let Some(all) = exhaustive(stored, &[], query, k, SearchCost { fell_back: true, ..cost })
        {
            return all;
        }
        stored.prefetch(lookup.shortlist());
        self.rerank(stored, simd, query, k);
        Search { neighbours: self.nearest.neighbours().collect(), cost }
    }

    /// Measures the candidates' distances, by their descriptors where these are kept, and keeps the
    /// k nearest.
    pub(crate) fn rerank(&mut self, stored: Stored<'_>, simd: Simd, query: &[f32], k: usize) {
        let Self { lookup, nearest, row } = self;
        nearest.reset(k);
        if stored.are_kept() {
            stored.measure(simd, query, lookup.shortlist(), row, nearest);
        } else {
            lookup.estimate(stored.entries, nearest);
        }
    }
}

/// Measures every entry; `None` where no descriptors are kept.
pub(crate) fn exhaustive(
    stored: Stored<'_>,
    files: &[&dyn ReadAhead],
    query: &[f32],
    k: usize,
    cost: SearchCost,
) -> Option<Search> {
    if !stored.are_kept() {
        return None;
    }
    let (mut neighbours, k) = (Vec::new(), k.min(stored.entries));
    let Ok(()) = nearest_of_many(stored, query, k, Threads::One, &mut neighbours, &mut ahead(files));
    let found_all = SearchCost { share_of_database: 1.0, exact: true, predicted_recall: Some(1.0), ..cost };
    Some(Search { neighbours, cost: SearchCost { reranked: stored.entries as u32, ..found_all } })
}

/// Has the blocks that are to be looked at next read ahead, so that they come while the one before
/// is looked at.
pub(crate) fn ahead<'s>(
    files: &[&dyn ReadAhead],
) -> impl FnMut(f64, &[(u32, Stored<'s>)]) -> Result<(), Infallible> {
    const BLOCKS: usize = 2;
    |_, to_come| {
        for (_, block) in to_come.iter().take(BLOCKS) {
            files.iter().for_each(|file| file.will_pass(block.bytes()));
        }
        Ok(())
    }
}
