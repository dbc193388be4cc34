//! From a descriptor to its nearest neighbours (the paper's Section V).
//!
//! The seam is [`Hash`]: a hash turns a vector into an ordered list of buckets to probe, and its buckets give candidates. What
//! follows is one path for every hash: the candidates' distances are measured by their descriptors, and the k nearest kept
//! ([`exact`]). [`searcher`] is the door to it all.
//!
//! - [`random`] is the paper's hash, with K and T learned from the data.
//! - [`learned`] fits the hyperplanes themselves to the data, and scans its buckets by 8-bit codes ([`blocks`], [`simd`]).
//! - [`measure`] finds out how many probes find how much ([`effort`]), so that a search is told what to find, not how.

pub(crate) mod blocks;
pub(crate) mod build;
pub(crate) mod distance;
pub(crate) mod effort;
mod exact;
pub(crate) mod joined;
pub(crate) mod learned;
pub(crate) mod measure;
#[cfg(feature = "parts")]
pub(crate) mod parts;
pub(crate) mod random;
pub(crate) mod searcher;
pub(crate) mod simd;
pub(crate) mod smallest;
pub(crate) mod stored;

use crate::file::bytes::Written;
use exact::Nearest;
use searcher::Scratch;
use simd::Simd;
use thiserror::Error;

/// What to search for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOptions {
    /// How many neighbours to return, at least 1. An index of fewer entries returns them all.
    pub k: usize,
    /// How hard to look for them.
    pub effort: Effort,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { k: 10, effort: Effort::Recall(0.95) }
    }
}

/// How hard to look for the neighbours: as a wanted success, which the index has measured the effort for, or as the effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// Find this share of the true 10 nearest, on average: above 0, at most 1.
    Recall(f64),
    /// Find, for the share `success` of all queries (above 0, at most 1), a neighbour at most `1 + eps` times as far as the
    /// true nearest (`eps` 0 or more).
    Success {
        /// How much farther than the true nearest is near enough.
        eps: f64,
        /// The share of queries for which it shall be found.
        success: f64,
    },
    /// Look into this many buckets of each table, at least 1.
    Probes(u32),
    /// Measure the distance to every entry: the true nearest neighbours, in time linear in the size of the index.
    Exact,
}

/// One entry of the index, as near as `distance` to the query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// The entry's number in the index.
    pub id: u32,
    /// The Euclidean distance between the descriptors.
    pub distance: f32,
}

impl Neighbour {
    /// Nearest first; equal distances by id.
    pub(crate) fn by_distance(&self, other: &Self) -> std::cmp::Ordering {
        self.distance.total_cmp(&other.distance).then(self.id.cmp(&other.id))
    }
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
    /// Candidates whose distance was measured by their original descriptors, after a coarser look at all of them.
    pub reranked: u32,
    /// The share of the true 10 nearest that such a search found when the index was measured; `None` where that is unknown.
    pub predicted_recall: Option<f64>,
}

/// What one segment of an index adds to a search of all: the candidates whose distance would be measured if it were all there is.
///
/// Of the shortlists of all segments, those `keep` with the least (key, id) are the candidates of a search of the whole index; where these are
/// fewer than the neighbours that are wanted, it searches again with twice the probes, up to `most_probes`, and then exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortlist {
    /// Buckets of each table that were looked into.
    pub probes: u32,
    /// More probes than that find no more.
    pub most_probes: u32,
    /// How many candidates a search measures at most; `None` for all.
    pub keep: Option<usize>,
    /// The candidates, nearest first, each with its key.
    pub candidates: Vec<(u32, Neighbour)>,
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
#[derive(Clone, Debug, Error, PartialEq)]
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
        /// Which value, counted over all queries of a batch.
        at: usize,
    },
    /// No search can reach what is wanted of it.
    #[error("{what} of {found} is not possible: it must be {wanted}")]
    Effort {
        /// What is wanted: a recall, a success or an eps.
        what: &'static str,
        /// How much of it.
        found: f64,
        /// Which numbers can be.
        wanted: &'static str,
    },
    /// Distances cannot be measured exactly.
    #[error(
        "the index keeps no descriptors to measure exact distances by: ask for less, or build it with `--originals f32`"
    )]
    NoOriginals,
    /// No neighbours were asked for.
    #[error("k is 0: ask for at least one neighbour")]
    NoNeighbours,
}

/// A hash turns a vector into an ordered list of buckets to probe, and its buckets into candidates.
pub(crate) trait Hash: Send + Sync {
    /// How many tables the buckets belong to.
    fn tables(&self) -> u32;

    /// More probes than that, of each table, find no more.
    fn most_probes(&self) -> u32;

    /// Lists in `scratch.buckets` the buckets to look into for `vector`, `probes` a table, the most promising first.
    fn probe(&self, simd: Simd, vector: &[f32], probes: u32, scratch: &mut Scratch);

    /// Names to `each` the parts of the file that [`Self::gather`] will look at.
    fn parts(&self, _: &Scratch, _: &mut dyn FnMut(&[u8])) {}

    /// Asks the memory for what [`Self::gather`] will look at.
    fn prefetch(&self, _: &Scratch) {}

    /// Lists in `scratch.candidates` the entries of those buckets that may be among the `k` nearest.
    fn gather(&self, simd: Simd, k: usize, scratch: &mut Scratch) {
        self.begin(k, scratch);
        self.scan(simd, 0, scratch);
        self.end(scratch);
    }

    /// Forgets the candidates of the query before.
    fn begin(&self, k: usize, scratch: &mut Scratch);

    /// Looks at the entries of those buckets, the first entry of all being number `first`.
    fn scan(&self, simd: Simd, first: u32, scratch: &mut Scratch);

    /// Lists the candidates that were found.
    fn end(&self, _: &mut Scratch) {}

    /// How many entries those buckets hold, each counted once; the first entry of all is number `first`.
    fn held(&self, first: u32, scratch: &Scratch) -> u32;

    /// How many candidates are kept at most, and for each that is, to `each`, the key by which it was kept, the smallest first;
    /// `None` where all are kept.
    fn keys(&self, _: &mut Scratch, _: &mut dyn FnMut(u32, u32)) -> Option<usize> {
        None
    }

    /// Offers the candidates to `nearest` at the squared distances that the hash itself knows of, if it does.
    fn estimate(&self, _: &mut Scratch, _: &mut Nearest) {}
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

/// The descriptors that an index is made of, where they have been written: who reads them says how.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) rows: Rows<'a>,
    pub(crate) file: &'a Written<'a>,
}

/// Checks queries and what is wanted of their search.
pub(crate) fn check(queries: &[f32], options: &SearchOptions) -> Result<(), SearchError> {
    if let Some(at) = queries.iter().position(|value| !value.is_finite()) {
        return Err(SearchError::NotFinite { at });
    }
    if options.k == 0 {
        return Err(SearchError::NoNeighbours);
    }
    let share = |what, found: f64| {
        let wanted = "above 0 and at most 1";
        let is_share = found > 0.0 && found <= 1.0;
        is_share.then_some(()).ok_or(SearchError::Effort { what, found, wanted })
    };
    match options.effort {
        Effort::Recall(recall) => share("a recall", recall),
        Effort::Success { eps, .. } if !(eps >= 0.0 && eps.is_finite()) => {
            Err(SearchError::Effort { what: "an eps", found: eps, wanted: "0 or more" })
        }
        Effort::Success { success, .. } => share("a success", success),
        Effort::Probes(_) | Effort::Exact => Ok(()),
    }
}

#[cfg(test)]
mod tests;
