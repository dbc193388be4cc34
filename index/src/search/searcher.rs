//! Many searches of one index.

use super::random::RandomHyperplanes;
use super::tables::Buckets;
use super::tune::Measured;
use super::{Effort, Neighbour, Rows, Search, SearchError, SearchOptions, check, exhaustive, search};

/// Searches one index, query after query. Each thread has its own.
#[derive(Debug)]
pub struct Searcher<'a> {
    rows: Rows<'a>,
    hash: RandomHyperplanes<'a>,
    buckets: Buckets<'a>,
    measured: Measured,
}

impl<'a> Searcher<'a> {
    pub(crate) fn new(
        rows: Rows<'a>,
        hash: RandomHyperplanes<'a>,
        buckets: Buckets<'a>,
        measured: Measured,
    ) -> Self {
        Self { rows, hash, buckets, measured }
    }

    /// The nearest neighbours of a descriptor.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the index.
    pub fn search(&mut self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        let dim = self.rows.dim;
        if query.len() != dim {
            return Err(SearchError::WrongLength { expected: dim, found: query.len() });
        }
        check(query, options)?;
        Ok(self.search_checked(query, options))
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
        let dim = self.rows.dim;
        let rest = queries.len() % dim.max(1);
        if rest != 0 {
            return Err(SearchError::WrongLength { expected: dim, found: rest });
        }
        check(queries, options)?;
        let missing = Neighbour { id: u32::MAX, distance: f32::INFINITY };
        for query in queries.chunks_exact(dim.max(1)) {
            let end = found.len() + options.k;
            found.extend(self.search_checked(query, options).neighbours);
            found.resize(end, missing);
        }
        Ok(())
    }

    fn search_checked(&mut self, query: &[f32], options: &SearchOptions) -> Search {
        let probes = match options.effort {
            Effort::Exact => return exhaustive(self.rows, query, options.k, Default::default()),
            Effort::Probes(probes) => probes,
            // The hash is sized for one effort: the one that was measured.
            Effort::Recall(_) | Effort::Success { .. } => self.hash.size.probes,
        };
        let mut found = search(self.rows, &self.hash, self.buckets, query, options.k, probes);
        if !found.cost.exact && probes == self.hash.size.probes {
            found.cost.predicted_recall = Some(self.measured.recall_at_10);
        }
        found
    }
}
