//! Several indexes that are searched as one.

use crate::file::catalogue::Catalogue;
use crate::file::error::FileChanged;
use crate::index::Index;
use crate::search::Originals;
use crate::search::searcher::{Searcher, reserve};
use crate::search::stored::{Several, Stored, Values};
use crate::search::{Neighbour, ReadAhead, Search, SearchCost, SearchError, SearchOptions};
use thiserror::Error;

/// Indexes of different entries, searched as if all entries were in one. An entry's number is the
/// one that it has in the index that all entries make together, in the order of the segments.
///
/// Segments of one index ([`Index::write_segment`]), in their order, answer exactly as that index
/// does, at any effort, to the last bit ([`Self::are_of_one_index`]). Others are searched each by
/// itself, as hard as is asked for, and what is found is merged by distance: of
/// [`crate::Effort::Exact`], that is exactly the answer of the index that they make together; of
/// less, together they find at least what is promised.
#[derive(Debug)]
pub struct Segments {
    indexes: Vec<Index>,
    /// The number of each one's first entry.
    starts: Vec<u32>,
    entries: usize,
    are_of_one_index: bool,
}

/// Indexes that cannot be searched as one.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SegmentsError {
    /// There is none.
    #[error("there is no index to search")]
    None,
    /// Their distances cannot be compared.
    #[error("index {at} (counted from 0) has other descriptors than the first: build one of them again")]
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
        let are_of_one_index =
            indexes.iter().all(|index| were_learned_together(first.catalogue(), index.catalogue()));
        Ok(Self { indexes, starts, entries: entries as usize, are_of_one_index })
    }

    /// The indexes, at least one.
    pub fn indexes(&self) -> &[Index] {
        &self.indexes
    }

    /// Whether everything that these indexes have said until now was read from one and the same
    /// files: [`Index::check_unchanged`] of each.
    ///
    /// # Errors
    /// [`FileChanged`], where it was not.
    pub fn check_unchanged(&self) -> Result<(), FileChanged> {
        self.indexes.iter().try_for_each(Index::check_unchanged)
    }

    /// Values of a descriptor.
    pub fn dim(&self) -> usize {
        self.indexes.first().map_or(0, Index::dim)
    }

    /// How many entries there are in all, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "an index is never empty")]
    pub fn len(&self) -> usize {
        self.entries
    }

    /// Whether all share what was learned from one index's entries, so that they are searched as
    /// that one.
    pub fn are_of_one_index(&self) -> bool {
        self.are_of_one_index
    }

    /// The index that holds an entry, and the entry's number there; `None` where there is no such
    /// entry.
    pub fn locate(&self, id: u32) -> Option<(&Index, u32)> {
        let at = self.starts.partition_point(|&start| start <= id).checked_sub(1)?;
        let (index, start) = (self.indexes.get(at)?, self.starts.get(at)?);
        let id = id - start;
        ((id as usize) < index.len()).then_some((index, id))
    }

    /// Searches the indexes, query after query.
    pub fn searcher(&self) -> SegmentsSearcher<'_> {
        let searchers = match &self.indexes[..] {
            [first, others @ ..] if self.are_of_one_index && !others.is_empty() => {
                vec![self.joined(first, others)]
            }
            each => each.iter().map(Index::searcher).collect(),
        };
        SegmentsSearcher { segments: self, searchers }
    }

    /// A searcher of all entries by the hash that the indexes share.
    fn joined<'a>(&'a self, first: &'a Index, others: &'a [Index]) -> Searcher<'a> {
        let mut hash = first.hash();
        for (&start, other) in self.starts.iter().skip(1).zip(others) {
            hash.join(start, other.hash());
        }
        let values = match first.catalogue().originals {
            Originals::None => Values::None,
            Originals::F32 | Originals::F16 => Values::Several(self),
        };
        let stored = Stored { dim: first.dim(), entries: self.entries, values };
        let files = self.indexes.iter().map(|index| index.bytes() as &dyn ReadAhead).collect();
        let is_cold = self.indexes.iter().map(Index::is_cold).collect();
        Searcher::new(stored, &hash, &first.catalogue().measured, files, is_cold)
    }

    /// The nearest neighbours of a descriptor in all indexes. For many queries, [`Self::searcher`]
    /// is faster.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the indexes.
    pub fn search(&self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        self.searcher().search(query, options)
    }

    /// Appends to `joined` the `k` nearest of what was found in each index, in their order, by its
    /// own numbers. Where there are fewer, the rest has the id `u32::MAX` and an infinite distance;
    /// entries passed in with that id are skipped.
    fn join<'f>(
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
        if let Some(own) = joined.get_mut(begin..) {
            own.sort_unstable_by(Neighbour::by_distance);
        }
        joined.resize(begin.saturating_add(k), Neighbour { id: u32::MAX, distance: f32::INFINITY });
    }

    /// What the searches of all indexes, in their order, cost together.
    fn cost(&self, costs: &[SearchCost]) -> SearchCost {
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

impl Several for Segments {
    fn locate(&self, id: u32) -> Option<(Stored<'_>, u32)> {
        Segments::locate(self, id).map(|(index, id)| (index.stored(), id))
    }

    fn all(&self) -> Vec<(u32, Stored<'_>)> {
        self.starts.iter().copied().zip(self.indexes.iter().map(Index::stored)).collect()
    }
}

/// Whether two indexes have the same hash, but for the entries in its buckets, and so were measured
/// as one.
fn were_learned_together(one: &Catalogue, other: &Catalogue) -> bool {
    let learned = |catalogue: &Catalogue| -> Vec<_> {
        let sections = catalogue.sections.iter().filter(|section| section.kind.is_learned());
        sections.map(|section| (section.kind, section.length, section.xxh3)).collect()
    };
    one.hash.without_entries() == other.hash.without_entries()
        && learned(one) == learned(other)
        && one.originals == other.originals
        && one.seed == other.seed
        && one.measured == other.measured
}

/// Searches several indexes as one, query after query. Each thread has its own.
#[derive(Debug)]
pub struct SegmentsSearcher<'a> {
    segments: &'a Segments,
    /// One of them all, or one of each.
    searchers: Vec<Searcher<'a>>,
}

impl SegmentsSearcher<'_> {
    /// The nearest neighbours of a descriptor in all indexes.
    ///
    /// # Errors
    /// [`SearchError`], when the query does not fit the indexes.
    pub fn search(&mut self, query: &[f32], options: &SearchOptions) -> Result<Search, SearchError> {
        if let [single] = &mut self.searchers[..] {
            return single.search(query, options);
        }
        let found: Vec<Search> = self
            .searchers
            .iter_mut()
            .map(|searcher| searcher.search(query, options))
            .collect::<Result<_, _>>()?;
        let mut neighbours = Vec::new();
        let each = found.iter().map(|search| &search.neighbours[..]);
        self.segments.join(each, options.k.min(self.segments.entries), &mut neighbours);
        let costs: Vec<SearchCost> = found.iter().map(|search| search.cost).collect();
        Ok(Search { neighbours, cost: self.segments.cost(&costs) })
    }

    /// The nearest neighbours of many descriptors, as [`Searcher::batch`] finds them.
    ///
    /// # Errors
    /// [`SearchError`], when a query does not fit the indexes; nothing is appended then.
    pub fn batch(
        &mut self,
        queries: &[f32],
        options: &SearchOptions,
        found: &mut Vec<Neighbour>,
    ) -> Result<(), SearchError> {
        if let [single] = &mut self.searchers[..] {
            return single.batch(queries, options, found);
        }
        reserve(found, options.k, queries.len() / self.segments.dim().max(1))?;
        let mut each = vec![Vec::new(); self.searchers.len()];
        for (searcher, found) in self.searchers.iter_mut().zip(&mut each) {
            searcher.batch(queries, options, found)?;
        }
        let mut rows: Vec<_> = each.iter().map(|found| found.chunks_exact(options.k)).collect();
        loop {
            let row: Vec<&[Neighbour]> = rows.iter_mut().filter_map(Iterator::next).collect();
            if row.is_empty() {
                return Ok(());
            }
            self.segments.join(row, options.k, found);
        }
    }
}
