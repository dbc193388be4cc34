//! The learned hash: hyperplanes fitted to the data instead of drawn at random.
//!
//! A table of `K` hyperplanes has `2^K` buckets, as in the paper, but each plane depends on the
//! bits before it: it is perpendicular to the direction in which the entries that share those bits
//! vary most ([`fit`]). Then every entry moves to the bucket whose centre is nearest, so that a
//! bucket is the cell of its centre.
//!
//! A query is turned into the data's principal axes ([`axes`]) and quantised once. Buckets are
//! ranked by the distance of their centres, in two levels: the groups of centres first, then the
//! centres of the nearest groups. The first buckets are scanned: their entries lie in blocks of
//! codes ([`super::blocks`]), the difference of each entry from its bucket's centre. A code has 4
//! bits where the index keeps descriptors, by which the best are measured in the end, else 8. From
//! a query q to an entry x = c + r, with centre c and residual r,
//!
//! `|q - x|^2 = |q - c|^2 + (|r|^2 + 2 <c, r>) - 2 <q, r>`:
//!
//! the first term comes from the ranking, the second is the entry's scalar, and the third a dot
//! product of integers. `|q|^2` is left out everywhere, as it is the same for all.

pub(crate) mod axes;
pub(crate) mod centres;
pub(crate) mod fit;
pub(crate) mod lookup;

use crate::search::blocks::{Blocks, CodeBits, LANES};
use axes::Axes;
use centres::{Centres, at_most, bounds};

/// The size of a learned hash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedHash {
    /// K: hyperplanes that an entry passes on its way into a bucket.
    pub planes: u32,
    /// P: principal axes that are quantised, a multiple of 4.
    pub axes: u32,
    /// Groups of centres.
    pub groups: u32,
    /// Blocks of sixteen centres; with the unused places in them, the buckets.
    pub centre_blocks: u32,
    /// Blocks of sixteen entries.
    pub entry_blocks: u32,
    /// The unit of the centres' codes.
    pub centre_scale: f32,
    /// The unit of the entries' codes.
    pub residual_scale: f32,
    /// The bits of the entries' codes.
    pub code_bits: CodeBits,
}

/// A learned hash and its buckets as they lie in the file. Nothing in them is trusted.
#[derive(Clone, Debug)]
pub(crate) struct Learned<'a> {
    pub(crate) axes: Axes<'a>,
    pub(crate) centres: Centres<'a>,
    /// The unit of the entries' codes.
    pub(crate) residual_scale: f32,
    /// The buckets' entries, file by file: a bucket holds those of the bucket of its number in
    /// each.
    pub(crate) files: Vec<Entries<'a>>,
}

/// The entries that the buckets hold in one file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a> {
    /// Where the blocks of each bucket start and end.
    pub(crate) directory: &'a [u32],
    /// Numbered from the file's first entry among those of all files.
    pub(crate) blocks: Blocks<'a>,
}

impl<'a> Entries<'a> {
    /// The blocks of a bucket.
    fn bucket(&self, bucket: u32) -> Blocks<'a> {
        let (start, end) = bounds(self.directory, bucket);
        self.blocks.run(start, end)
    }
}

impl<'a> Learned<'a> {
    /// As many as there are places for centres.
    pub(crate) fn most_probes(&self) -> u32 {
        u32::try_from(self.centres.buckets.len() * LANES).unwrap_or(u32::MAX)
    }

    /// The blocks of the given buckets, all buckets of one file before those of the next.
    fn runs<'l>(&'l self, buckets: &'l [(f32, u32)]) -> impl Iterator<Item = (f32, Blocks<'a>)> + Clone + 'l {
        self.files.iter().flat_map(|file| {
            let runs = buckets.iter().map(|&(base, bucket)| (base, file.bucket(bucket)));
            at_most(file.blocks, runs)
        })
    }
}
