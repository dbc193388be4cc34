//! Several indexes that are searched as one.

use crate::index::Index;
use crate::search::{Neighbour, Search, SearchCost, SearchError, SearchOptions};
use thiserror::Error;

/// Indexes of different entries, searched as if all entries were in one: each is searched by itself, and what is found is merged by
/// distance.
///
/// An entry's number is the one that it has in the index that all entries make together, in the order of the segments. Answers of
/// [`crate::Effort::Exact`] are exactly those of that index. Every segment looks as hard as it is asked to: of an effort that is
/// less than exact, segments together find at least what is promised.
#[derive(Debug)]
pub struct Segments {
    indexes: Vec<Index>,
    /// The number of each one's first entry.
    starts: Vec<u32>,
    entries: usize,
}

/// Indexes that cannot be searched as one.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SegmentsError {
    /// There is none.
    #[error("there is no index to search")]
    None,
    /// Their distances cannot be compared.
    #[error("index {at} (counted from 0) has other descriptors than the first: build one of them anew")]
    Unlike {
        /// Which differs.
        at: usize,
    },
    /// Their entries cannot be numbered.
    #[error("together the indexes hold {0} entries, more than can be numbered: search them in two groups")]
    TooMany(u64),
}

impl Segments {
    /// Takes indexes as one.
    ///
    /// # Errors
    /// [`SegmentsError`], when they do not go together.
    pub fn new(indexes: Vec<Index>) -> Result<Self, SegmentsError> {
        let first = indexes.first().ok_or(SegmentsError::None)?;
        if let Some(at) = indexes.iter().position(|index| index.params_hash() != first.params_hash()) {
            return Err(SegmentsError::Unlike { at });
        }
        let entries: u64 = indexes.iter().map(|index| index.len() as u64).sum();
        // The last number stands for no entry.
        if entries >= u64::from(u32::MAX) {
            return Err(SegmentsError::TooMany(entries));
        }
        let start = |start: &mut u32, index: &Index| {
            let next = *start + index.len() as u32;
            Some(std::mem::replace(start, next))
        };
        let starts = indexes.iter().scan(0, start).collect();
        Ok(Self { indexes, starts, entries: entries as usize })
    }

    /// The indexes, at least one.
    pub fn indexes(&self) -> &[Index] {
        &self.indexes
    }

    /// How many entries there are in all, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "an index is never empty")]
    pub fn len(&self) -> usize {
        self.entries
    }

    /// The index that holds an entry, and the entry's number there; `None` where there is no such entry.
    pub fn locate(&self, id: u32) -> Option<(&Index, u32)> {
        let at = self.starts.partition_point(|&start| start <= id).checked_sub(1)?;
        let (index, start) = (self.indexes.get(at)?, self.starts.get(at)?);
        let id = id - start;
        ((id as usize) < index.len()).then_some((index, id))
    }

    /// Appends to `joined` the `k` nearest of what was found in each index, in their order, by its own numbers. Where there are fewer,
    /// the rest has the id `u32::MAX` and an infinite distance, as does what is passed in so.
    pub fn join<'f>(
        &self,
        found: impl IntoIterator<Item = &'f [Neighbour]>,
        k: usize,
        joined: &mut Vec<Neighbour>,
    ) {
        let begin = joined.len();
        for (start, neighbours) in self.starts.iter().zip(found) {
            let present = neighbours.iter().filter(|neighbour| neighbour.id != u32::MAX);
            let numbered =
                |neighbour: &Neighbour| Neighbour { id: neighbour.id.saturating_add(*start), ..*neighbour };
            joined.extend(present.map(numbered));
        }
        let by_distance =
            |a: &Neighbour, b: &Neighbour| a.distance.total_cmp(&b.distance).then(a.id.cmp(&b.id));
        if let Some(own) = joined.get_mut(begin..) {
            own.sort_unstable_by(by_distance);
        }
        joined.resize(begin.saturating_add(k), Neighbour { id: u32::MAX, distance: f32::INFINITY });
    }

    /// The nearest neighbours of a descriptor in all indexes.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the indexes.
    pub fn search(&self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        let found: Vec<Search> =
            self.indexes.iter().map(|index| index.search(query, options)).collect::<Result<_, _>>()?;
        let mut neighbours = Vec::new();
        self.join(
            found.iter().map(|search| &search.neighbours[..]),
            options.k.min(self.entries),
            &mut neighbours,
        );
        let costs: Vec<SearchCost> = found.iter().map(|search| search.cost).collect();
        Ok(Search { neighbours, cost: self.cost(&costs) })
    }

    /// What the searches of all indexes, in their order, cost together.
    pub fn cost(&self, costs: &[SearchCost]) -> SearchCost {
        let looked_at: f64 = costs
            .iter()
            .zip(&self.indexes)
            .map(|(cost, index)| cost.share_of_database * index.len() as f64)
            .sum();
        SearchCost {
            tables: costs.iter().map(|cost| cost.tables).max().unwrap_or_default(),
            buckets: costs.iter().map(|cost| cost.buckets).sum(),
            candidates: costs.iter().map(|cost| cost.candidates).sum(),
            share_of_database: looked_at / self.entries as f64,
            exact: costs.iter().all(|cost| cost.exact),
            fell_back: costs.iter().any(|cost| cost.fell_back),
            reranked: costs.iter().map(|cost| cost.reranked).sum(),
            predicted_recall: costs
                .iter()
                .map(|cost| cost.predicted_recall)
                .reduce(|one, other| one.zip(other).map(|(one, other)| one.min(other)))
                .flatten(),
        }
    }
}
