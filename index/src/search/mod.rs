//! From a descriptor to its nearest neighbours (the paper's Section V).
//!
//! The seam is [`Hash`]: a hash turns a vector into an ordered list of buckets to probe. What follows is one path for
//! every hash: gather the union of the buckets ([`tables`]), measure exact distances, keep the k nearest ([`exact`]).
//! [`random`] holds the paper's hash, and [`tune`] chooses its size from the data.

pub(crate) mod distance;
mod exact;
pub(crate) mod random;
pub(crate) mod tables;
pub(crate) mod tune;

use exact::Nearest;
use tables::Buckets;
use thiserror::Error;

/// What to search for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SearchOptions {
    /// How many neighbours to return, at least 1. An index of fewer entries returns them all.
    pub k: usize,
    /// Measure the distance to every entry: the true nearest neighbours, in time linear in the size of the index.
    pub exact: bool,
    /// Buckets to probe in each table: 1 is the paper's search, more find more. `None` takes what the index was
    /// measured with.
    pub probes: Option<u32>,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { k: 10, exact: false, probes: None }
    }
}

/// One entry of the index, as near as `distance` to the query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// The entry's number in the index.
    pub id: u32,
    /// The Euclidean distance between the descriptors.
    pub distance: f32,
}

/// What a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchCost {
    /// Tables that were looked into.
    pub tables: u32,
    /// Buckets that were looked into, over all tables.
    pub buckets: u32,
    /// Entries that the buckets held, each counted once: all distances that were measured, unless `exact`.
    pub candidates: u32,
    /// The share of the index whose distance was measured, 0 to 1.
    pub share_of_database: f64,
    /// Every entry was measured: the neighbours are the true ones.
    pub exact: bool,
    /// The buckets held fewer than k entries, so every entry was measured although that was not asked for.
    pub fell_back: bool,
}

/// Neighbours, and what it took to find them.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Nearest first; equal distances by id.
    pub neighbours: Vec<Neighbour>,
    /// What the search did.
    pub cost: SearchCost,
}

/// A query that cannot be searched for.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SearchError {
    /// The query has another length than the index's descriptors.
    #[error(
        "the query has {found} values, the index's descriptors have {expected}: describe pictures with the index's own parameters"
    )]
    WrongLength {
        /// Values of a descriptor of the index.
        expected: usize,
        /// Values of the query.
        found: usize,
    },
    /// The query holds an infinity or a NaN.
    #[error("value {at} of the query is not a finite number")]
    NotFinite {
        /// Which value.
        at: usize,
    },
    /// No neighbours were asked for.
    #[error("k is 0: ask for at least one neighbour")]
    NoNeighbours,
}

/// A hash turns a vector into an ordered list of buckets to probe, most promising first.
pub(crate) trait Hash: Sync {
    /// How many tables the buckets belong to.
    fn tables(&self) -> u32;

    /// Appends the buckets to probe for `vector`, `probes` a table, to `buckets`.
    fn probe(&self, vector: &[f32], probes: u32, buckets: &mut Vec<u32>);
}

/// The descriptors of an index: rows of `dim` values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) values: &'a [f32],
    pub(crate) dim: usize,
}

impl<'a> Rows<'a> {
    pub(crate) fn len(&self) -> usize {
        self.values.len() / self.dim.max(1)
    }

    /// Row `id`; `None` past the end, as an id read from a file may be.
    pub(crate) fn get(&self, id: u32) -> Option<&'a [f32]> {
        let start = (id as usize).checked_mul(self.dim)?;
        self.values.get(start..start.checked_add(self.dim)?)
    }
}

/// Searches `rows` through `hash` and its `buckets`. The query has been checked with [`check`].
pub(crate) fn search(
    rows: Rows<'_>,
    hash: &dyn Hash,
    buckets: Buckets<'_>,
    query: &[f32],
    options: &SearchOptions,
    default_probes: u32,
) -> Search {
    if options.exact {
        return exhaustive(rows, query, options.k, SearchCost::default());
    }
    let mut probed = Vec::new();
    hash.probe(query, options.probes.unwrap_or(default_probes).max(1), &mut probed);
    let candidates = tables::union(buckets, &probed, rows.len());
    let cost = SearchCost {
        tables: hash.tables(),
        buckets: probed.len() as u32,
        candidates: candidates.len() as u32,
        share_of_database: candidates.len() as f64 / rows.len().max(1) as f64,
        exact: false,
        fell_back: false,
    };
    if candidates.len() < options.k.min(rows.len()) {
        return exhaustive(rows, query, options.k, SearchCost { fell_back: true, ..cost });
    }
    let mut nearest = Nearest::new(options.k);
    for id in candidates {
        if let Some(row) = rows.get(id) {
            nearest.offer(id, distance::squared(query, row));
        }
    }
    Search { neighbours: nearest.into_neighbours(), cost }
}

/// Measures every row.
fn exhaustive(rows: Rows<'_>, query: &[f32], k: usize, cost: SearchCost) -> Search {
    let neighbours = exact::nearest(rows, query, k, None);
    Search { neighbours, cost: SearchCost { share_of_database: 1.0, exact: true, ..cost } }
}

/// Checks a query against the index's descriptors.
pub(crate) fn check(query: &[f32], dim: usize, options: &SearchOptions) -> Result<(), SearchError> {
    if query.len() != dim {
        return Err(SearchError::WrongLength { expected: dim, found: query.len() });
    }
    if let Some(at) = query.iter().position(|value| !value.is_finite()) {
        return Err(SearchError::NotFinite { at });
    }
    if options.k == 0 {
        return Err(SearchError::NoNeighbours);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
