//! The seam between the hashes and the path that they share: a hash turns a vector into an ordered
//! list of buckets to probe, and its buckets into candidates.

use super::learned::lookup::{Lookup as LearnedLookup, Rotated};
use super::learned::{Learned, LearnedHash};
use super::nearest::Nearest;
use super::random::lookup::{Located as RandomLocated, Lookup as RandomLookup};
use super::random::{Random, RandomHash};
use super::simd::Simd;
use std::collections::HashMap;

/// Which hash the buckets were made by, and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum HashInfo {
    /// The paper's random hyperplanes.
    Random(RandomHash),
    /// Hyperplanes fitted to the data.
    Learned(LearnedHash),
}

impl HashInfo {
    /// With nothing in its buckets.
    pub(crate) fn without_entries(self) -> Self {
        self.with_entry_blocks(0)
    }

    /// The same hash with `entry_blocks` blocks of entries; a random hash has none.
    pub(crate) fn with_entry_blocks(self, entry_blocks: u32) -> Self {
        match self {
            Self::Learned(hash) => Self::Learned(LearnedHash { entry_blocks, ..hash }),
            Self::Random(_) => self,
        }
    }
}

/// A hash and its buckets, which may lie in several files.
#[derive(Clone, Debug)]
pub(crate) enum Hash<'a> {
    Random(Random<'a>),
    Learned(Learned<'a>),
}

impl<'a> Hash<'a> {
    /// More probes than that, of each table, find no more.
    pub(crate) fn most_probes(&self) -> u32 {
        match self {
            Self::Random(hash) => hash.most_probes(),
            Self::Learned(hash) => hash.most_probes(),
        }
    }

    /// Adds the entries of another file, the first of which is number `first`. Both hashes were
    /// learned as one, so that a bucket holds the entries of the bucket of its number in each file:
    /// what is looked at, and what is kept of it, is what a single file of all entries would give.
    pub(crate) fn join(&mut self, first: u32, other: Hash<'a>) {
        match (self, other) {
            (Self::Random(own), Self::Random(other)) => {
                own.files.extend(other.files.into_iter().map(|mut file| {
                    file.first = file.first.wrapping_add(first);
                    file
                }));
            }
            (Self::Learned(own), Self::Learned(other)) => {
                own.files.extend(other.files.into_iter().map(|mut file| {
                    file.blocks = file.blocks.numbered_from(first);
                    file
                }));
            }
            _ => debug_assert!(false, "hashes of two kinds were not learned as one"),
        }
    }
}

/// What a hash knows of a query, however many buckets are looked into for it.
#[derive(Clone, Debug)]
pub(crate) enum Located {
    Random(RandomLocated),
    Learned(Rotated),
}

/// One query after another on its way through a hash, with the memory that this hash needs for it.
#[expect(clippy::large_enum_variant, reason = "a searcher has three, and nearly always of the larger kind")]
#[derive(Clone, Debug)]
pub(crate) enum Lookup<'a> {
    Random(RandomLookup<'a>),
    Learned(LearnedLookup<'a>),
}

impl<'a> Lookup<'a> {
    pub(crate) fn new(hash: &Hash<'a>) -> Self {
        match hash {
            Hash::Random(hash) => Self::Random(RandomLookup::new(hash.clone())),
            Hash::Learned(hash) => Self::Learned(LearnedLookup::new(hash.clone())),
        }
    }

    /// How many tables the buckets belong to.
    pub(crate) fn tables(&self) -> u32 {
        match self {
            Self::Random(lookup) => lookup.hash().tables(),
            Self::Learned(_) => 1,
        }
    }

    /// As [`Hash::most_probes`].
    pub(crate) fn most_probes(&self) -> u32 {
        match self {
            Self::Random(lookup) => lookup.hash().most_probes(),
            Self::Learned(lookup) => lookup.hash().most_probes(),
        }
    }

    /// Chooses the buckets to look into for `vector`, `probes` a table, the most promising first.
    pub(crate) fn probe(&mut self, simd: Simd, vector: &[f32], probes: u32) {
        self.locate(simd, vector);
        self.rank(simd, probes);
    }

    /// Takes up a query: what is the same however many buckets are looked into.
    pub(crate) fn locate(&mut self, simd: Simd, vector: &[f32]) {
        match self {
            Self::Random(lookup) => lookup.locate(vector),
            Self::Learned(lookup) => lookup.rotate(simd, vector),
        }
    }

    /// The query that was located last.
    pub(crate) fn located(&self) -> Located {
        match self {
            Self::Random(lookup) => Located::Random(lookup.query.clone()),
            Self::Learned(lookup) => Located::Learned(lookup.query.clone()),
        }
    }

    /// Takes up again a query that a lookup of the same hash has located.
    pub(crate) fn resume(&mut self, located: &Located) {
        match (self, located) {
            (Self::Random(lookup), Located::Random(query)) => lookup.query.clone_from(query),
            (Self::Learned(lookup), Located::Learned(query)) => lookup.query.clone_from(query),
            _ => debug_assert!(false, "a lookup of another hash has located the query"),
        }
    }

    /// As [`Self::probe`], for the query that was located last.
    pub(crate) fn rank(&mut self, simd: Simd, probes: u32) {
        match self {
            Self::Random(lookup) => lookup.rank(probes),
            Self::Learned(lookup) => lookup.rank(simd, probes),
        }
    }

    /// Names to `each` the parts of the file that [`Self::gather`] will look at, where these are
    /// worth reading ahead.
    pub(crate) fn for_each_part(&self, each: impl FnMut(&[u8])) {
        if let Self::Learned(lookup) = self {
            lookup.parts().for_each(each);
        }
    }

    /// Asks the memory for what [`Self::gather`] will look at.
    pub(crate) fn prefetch(&self) {
        if let Self::Learned(lookup) = self {
            lookup.prefetch();
        }
    }

    /// Takes from the chosen buckets the entries that may be among the `k` nearest: the shortlist.
    pub(crate) fn gather(&mut self, simd: Simd, k: usize) {
        match self {
            Self::Random(lookup) => lookup.gather(),
            Self::Learned(lookup) => lookup.gather(simd, k),
        }
    }

    /// How many buckets were chosen.
    pub(crate) fn buckets(&self) -> usize {
        match self {
            Self::Random(lookup) => lookup.buckets(),
            Self::Learned(lookup) => lookup.buckets(),
        }
    }

    /// How many entries they hold, each counted once.
    pub(crate) fn held(&self) -> u32 {
        match self {
            Self::Random(lookup) => lookup.shortlist().len() as u32,
            Self::Learned(lookup) => lookup.held(),
        }
    }

    /// The entries whose distance is to be measured.
    pub(crate) fn shortlist(&self) -> &[u32] {
        match self {
            Self::Random(lookup) => lookup.shortlist(),
            Self::Learned(lookup) => lookup.shortlist(),
        }
    }

    /// How many candidates are kept at most, and the key by which each was kept, by id; `None`
    /// where all are kept.
    pub(crate) fn keys(&mut self) -> Option<(usize, HashMap<u32, u32>)> {
        match self {
            Self::Random(_) => None,
            Self::Learned(lookup) => {
                let keep = lookup.keep();
                Some((keep, lookup.keys().map(|(key, id)| (id, key)).collect()))
            }
        }
    }

    /// Offers the candidates to `nearest` at the squared distances that the hash itself knows of,
    /// if it does.
    pub(crate) fn estimate(&mut self, entries: usize, nearest: &mut Nearest) {
        if let Self::Learned(lookup) = self {
            lookup.estimate(entries, nearest);
        }
    }
}
