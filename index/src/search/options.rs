//! What a search is asked for, and why it cannot be.

use super::distance::LARGEST_VALUE;
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

/// How hard to look for the neighbours: as a wanted success, which the index has measured the
/// effort for, or as the effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// Find this share of the true 10 nearest, on average: above 0, at most 1.
    Recall(f64),
    /// Find, for the share `success` of all queries (above 0, at most 1), a neighbour at most `1 +
    /// eps` times as far as the true nearest (`eps` 0 or more).
    Success {
        /// How much farther than the true nearest is near enough.
        eps: f64,
        /// The share of queries for which it shall be found.
        success: f64,
    },
    /// Look into this many buckets of each table, at least 1.
    Probes(u32),
    /// Measure the distance to every entry: the true nearest neighbours, in time linear in the size
    /// of the index.
    Exact,
}

impl Effort {
    /// The success that an eps alone asks for, as in the paper.
    pub const DEFAULT_SUCCESS: f64 = 0.95;
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
    /// The query holds a value whose distance from an entry would not be finite.
    #[error(
        "value {at} of the query is larger than {LARGEST_VALUE:e}: scale it as the index's descriptors are"
    )]
    Huge {
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
    /// No effort was measured to be enough, and not every entry can be compared with.
    #[error(
        "searches of the index were measured to find {best:.3} of the nearest entries at most, and it keeps no descriptors \
         to compare with all: ask for less with --recall, or build it with `--originals f32`"
    )]
    NotReached {
        /// The largest recall of ten that was measured.
        best: f64,
    },
    /// There is no memory for the rows of neighbours that were asked for.
    #[error("{k} neighbours for each of {queries} queries do not fit into memory: ask for fewer")]
    TooManyNeighbours {
        /// How many for each query.
        k: usize,
        /// How many queries.
        queries: usize,
    },
    /// No neighbours were asked for.
    #[error("k is 0: ask for at least one neighbour")]
    NoNeighbours,
}

/// Checks queries and what is wanted of their search.
pub(crate) fn check(queries: &[f32], options: &SearchOptions) -> Result<(), SearchError> {
    if let Some(at) = queries.iter().position(|value| !value.is_finite() || value.abs() > LARGEST_VALUE) {
        let is_finite = queries[at].is_finite();
        return Err(if is_finite { SearchError::Huge { at } } else { SearchError::NotFinite { at } });
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
        Effort::Probes(0) => {
            Err(SearchError::Effort { what: "a number of probes", found: 0.0, wanted: "at least 1" })
        }
        Effort::Probes(_) | Effort::Exact => Ok(()),
    }
}
