//! The learned hash: hyperplanes fitted to the data instead of drawn at random.
//!
//! A table of `K` hyperplanes has `2^K` buckets, as in the paper, but each plane depends on the bits before it: it stands
//! upright on the direction in which the entries that share those bits vary most ([`fit`]). Then every entry moves to the
//! bucket whose centre is nearest, so that a bucket is the cell of its centre.
//!
//! A query is turned into the data's principal axes ([`axes`]) and quantised once. Buckets are ranked by the distance of
//! their centres, in two levels: the groups of centres first, then the centres of the nearest groups. The first
//! buckets are scanned: their entries lie in blocks of 8-bit codes ([`super::blocks`]), the difference of each entry from its
//! bucket's centre. From a query q to an entry x = c + r, with centre c and residual r,
//!
//! `|q - x|^2 = |q - c|^2 + (|r|^2 + 2 <c, r>) - 2 <q, r>`:
//!
//! the first term comes from the ranking, the second is the entry's scalar, and the third a dot product of whole numbers. `|q|^2`
//! is left out everywhere, as it is the same for all.

pub(crate) mod axes;
pub(crate) mod fit;

use super::Hash;
use super::blocks::{Blocks, LANES};
use super::exact::Nearest;
use super::searcher::Scratch;
use super::simd::{self, Simd};
use axes::Axes;
use rkyv::{Archive, Deserialize, Serialize};

/// Entries that are measured exactly besides the k that are wanted: half as many again, at least this, and one for every four
/// buckets, because who looks into many does not want to lose a neighbour to the codes' rounding.
const MORE: usize = 4;
/// More are never measured exactly, whatever k is asked for.
const MOST: usize = 1 << 30;
/// Bytes of a bucket that are asked for ahead of their use; the processor follows by itself.
const PREFETCHED: usize = 2048;

/// The size of a learned hash.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
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
}

/// A learned hash and its buckets as they lie in the file. Nothing in them is trusted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Learned<'a> {
    pub(crate) size: LearnedHash,
    pub(crate) axes: Axes<'a>,
    /// The centres of the groups.
    pub(crate) groups: Blocks<'a>,
    /// Where the blocks of centres of each group start and end.
    pub(crate) group_directory: &'a [u32],
    /// The centres of the buckets, group by group: a bucket's number is the place of its centre.
    pub(crate) centres: Blocks<'a>,
    /// Where the blocks of entries of each bucket start and end.
    pub(crate) bucket_directory: &'a [u32],
    pub(crate) entries: Blocks<'a>,
}

impl Learned<'_> {
    /// The groups of centres whose buckets are ranked when `probes` of them are wanted.
    pub(crate) fn groups_for(&self, probes: u32) -> u32 {
        probes.saturating_add(probes / 2).saturating_add(6)
    }

    /// Turns the query into the principal axes and quantises it.
    pub(crate) fn rotate(&self, simd: Simd, vector: &[f32], scratch: &mut Scratch) {
        scratch.coordinates.resize(self.axes.count, 0.0);
        self.axes.project(simd, vector, &mut scratch.coordinates);
        scratch.query.set(&scratch.coordinates);
    }

    /// Ranks the buckets for the quantised query: the `probes` nearest of the `groups` nearest groups.
    pub(crate) fn rank(&self, simd: Simd, groups: u32, probes: u32, scratch: &mut Scratch) {
        let Scratch { query, nearest, groups: chosen, buckets, .. } = scratch;
        let factor = 2.0 * self.size.centre_scale * query.step;
        chosen.clear();
        if groups >= self.size.groups {
            chosen.extend(0..self.size.groups);
        } else {
            nearest.reset(groups as usize);
            simd.scan(self.groups, query, factor, 0.0, nearest);
            chosen.extend(nearest.unsorted().map(|(_, group)| group));
        }
        nearest.reset(probes as usize);
        for &group in chosen.iter() {
            let (start, end) = bounds(self.group_directory, group);
            simd.scan(self.centres.run(start, end), query, factor, 0.0, nearest);
        }
        buckets.clear();
        buckets.extend(nearest.sorted());
    }

    /// The blocks of a bucket.
    fn bucket(&self, bucket: u32) -> Blocks<'_> {
        let (start, end) = bounds(self.bucket_directory, bucket);
        self.entries.run(start, end)
    }
}

impl Hash for Learned<'_> {
    fn tables(&self) -> u32 {
        1
    }

    fn most_probes(&self) -> u32 {
        self.size.centre_blocks.saturating_mul(LANES as u32)
    }

    fn probe(&self, simd: Simd, vector: &[f32], probes: u32, scratch: &mut Scratch) {
        self.rotate(simd, vector, scratch);
        // A damaged or hostile request may ask for more than there is.
        let probes = probes.min(self.most_probes());
        self.rank(simd, self.groups_for(probes), probes, scratch);
    }

    fn parts(&self, scratch: &Scratch, each: &mut dyn FnMut(&[u8])) {
        for &(_, bucket) in &scratch.buckets {
            each(self.bucket(bucket).bytes());
        }
    }

    fn prefetch(&self, scratch: &Scratch) {
        for &(_, bucket) in &scratch.buckets {
            let run = self.bucket(bucket);
            simd::prefetch_all(&run.bytes()[..run.bytes().len().min(PREFETCHED)]);
        }
    }

    /// Of the entries that are scanned, the nearest by their codes will be kept.
    fn begin(&self, k: usize, scratch: &mut Scratch) {
        let more = (k / 2).max(MORE) + scratch.buckets.len() / 4;
        scratch.found.reset(k.saturating_add(more).min(MOST));
    }

    fn scan(&self, simd: Simd, first: u32, scratch: &mut Scratch) {
        let Scratch { query, buckets, found, .. } = scratch;
        let factor = 2.0 * self.size.residual_scale * query.step;
        for &(base, bucket) in buckets.iter() {
            let run = self.bucket(bucket).numbered_from(first);
            simd.scan(run, query, factor, base, found);
        }
    }

    fn end(&self, scratch: &mut Scratch) {
        let Scratch { found, candidates, .. } = scratch;
        candidates.clear();
        candidates.extend(found.unsorted().map(|(_, id)| id));
    }

    fn held(&self, _: u32, scratch: &Scratch) -> u32 {
        let buckets = scratch.buckets.iter().map(|&(_, bucket)| self.bucket(bucket).vectors());
        buckets.sum()
    }

    fn keys(&self, scratch: &mut Scratch, each: &mut dyn FnMut(u32, u32)) -> Option<usize> {
        scratch.found.keys().for_each(|(key, id)| each(key, id));
        Some(scratch.found.keep())
    }

    fn estimate(&self, scratch: &mut Scratch, nearest: &mut Nearest) {
        // The query's own length, which the scores leave out.
        let square: f32 = scratch.coordinates.iter().map(|value| value * value).sum();
        for (score, id) in scratch.found.unsorted() {
            nearest.offer(id, (score + square).max(0.0));
        }
    }
}

/// Where the blocks of one number start and end; nowhere where the directory makes no sense.
fn bounds(directory: &[u32], number: u32) -> (u32, u32) {
    let bounds = directory.get(number as usize).zip(directory.get(number as usize + 1));
    bounds.map_or((0, 0), |(&start, &end)| (start, end))
}
