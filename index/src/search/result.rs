//! What a search returns.

use super::nearest::Neighbour;

/// What a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchCost {
    /// Tables that were looked into.
    pub tables: u32,
    /// Buckets that were looked into, over all tables.
    pub buckets: u32,
    /// Entries in those buckets, each counted once. With a fitted hash their codes were compared,
    /// with a random one their distances measured; 0 where the search was exact from the start.
    pub candidates: u32,
    /// The same as a share of the index, 0 to 1.
    pub share_of_database: f64,
    /// Every entry was measured: the neighbours are the true ones.
    pub exact: bool,
    /// The buckets held fewer than k entries, so every entry was measured although that was not
    /// asked for.
    pub fell_back: bool,
    /// Candidates whose distance was measured by their original descriptors, after a coarser look
    /// at all of them.
    pub reranked: u32,
    /// The share of the true 10 nearest that such a search found when the index was measured;
    /// `None` where that is unknown.
    pub predicted_recall: Option<f64>,
}

/// What one segment of an index adds to a search of all: the candidates whose distance would be
/// measured if it were all there is.
///
/// Of the shortlists of all segments, those `keep` with the least (key, id) are the candidates of a
/// search of the whole index; where these are fewer than the neighbours that are wanted, it
/// searches again with twice the probes, up to `most_probes`, and then exactly.
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
