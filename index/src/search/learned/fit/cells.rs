//! The centres of the buckets, and the groups of them.

use super::tree::Leaves;
use crate::search::blocks::{self, BlockMut, Blocks, CodeBits, LANES, QuantisedQuery};
use crate::search::counting_sort::counting_sort;
use crate::search::learned::centres::{Centres, Ranking};
use crate::search::simd::Simd;
use rayon::prelude::*;
use rkyv::util::AlignedVec;

/// Rows that are worked on at a time by one thread.
pub(super) const CHUNK: usize = 1024;
/// Of all groups, the share in which an entry looks for its centre, at least [`LEAST_GROUPS`].
const SHARE_OF_GROUPS: f64 = 0.06;
const LEAST_GROUPS: u32 = 10;
/// With so many planes or fewer, all centres are one group.
const UNGROUPED: u32 = 8;
/// Rounds in which groups are made even.
const GROUP_ROUNDS: usize = 3;

/// Centres in groups, ready to be ranked.
pub(super) struct Cells {
    axes: usize,
    scale: f32,
    /// The codes of every place; zeros where it is unused.
    codes: Vec<i8>,
    group_blocks: AlignedVec<64>,
    group_directory: Vec<u32>,
    centre_blocks: AlignedVec<64>,
}

impl Cells {
    /// One centre for each leaf that is not empty, grouped by the tree's first planes.
    pub(super) fn new(codes: &[i8], axes: usize, leaves: &Leaves, planes: u32, scale: f32) -> Self {
        let members: Vec<&[u32]> = leaves.iter().collect();
        let centres: Vec<Option<Vec<i8>>> =
            members.par_iter().map(|ids| middle(codes, axes, ids.iter().copied())).collect();
        // A few hundred centres are ranked faster than groups of them are.
        let group_planes = if planes <= UNGROUPED { 0 } else { planes.div_ceil(2) };
        let group = |leaf: usize| leaf >> (planes - group_planes);
        let placed = centres.into_iter().enumerate().filter_map(|(leaf, codes)| Some((group(leaf), codes?)));
        Self::group(axes, scale, 1 << group_planes, placed)
    }

    /// Lays centres out by group; groups without a centre vanish.
    fn group(
        axes: usize,
        scale: f32,
        groups: usize,
        centres: impl Iterator<Item = (usize, Vec<i8>)>,
    ) -> Self {
        let mut by_group = vec![Vec::new(); groups];
        for (group, codes) in centres {
            by_group[group].push(codes);
        }
        by_group.retain(|centres| !centres.is_empty());
        let mut cells = Self {
            axes,
            scale,
            codes: Vec::new(),
            group_blocks: AlignedVec::new(),
            group_directory: vec![0],
            centre_blocks: AlignedVec::new(),
        };
        let mut group_centres = Vec::new();
        for centres in &by_group {
            let flat = centres.concat();
            group_centres.extend(middle(&flat, axes, 0..centres.len() as u32).unwrap_or_default());
            cells.codes.extend(&flat);
            cells.codes.resize(cells.codes.len().next_multiple_of(LANES * axes), 0);
            put_centres(&mut cells.centre_blocks, axes, scale, &flat);
            cells.group_directory.push((cells.centre_blocks.len() / blocks::centre_stride(axes)) as u32);
        }
        put_centres(&mut cells.group_blocks, axes, scale, &group_centres);
        cells
    }

    pub(super) fn groups(&self) -> usize {
        self.group_directory.len() - 1
    }

    /// Places for centres, some of them unused: numbers of buckets are below.
    pub(super) fn places(&self) -> usize {
        self.codes.len() / self.axes
    }

    /// The codes of a bucket's centre.
    pub(super) fn centre(&self, bucket: u32) -> &[i8] {
        &self.codes[bucket as usize * self.axes..][..self.axes]
    }

    pub(super) fn scale(&self) -> f32 {
        self.scale
    }

    pub(super) fn into_parts(self) -> (AlignedVec<64>, Vec<u32>, AlignedVec<64>) {
        (self.group_blocks, self.group_directory, self.centre_blocks)
    }

    fn as_centres(&self) -> Centres<'_> {
        Centres {
            scale: self.scale,
            groups: Blocks::of_centres(&self.group_blocks, self.axes),
            group_directory: &self.group_directory,
            buckets: Blocks::of_centres(&self.centre_blocks, self.axes),
        }
    }

    /// The bucket of every row of codes: the one that a query there would probe first.
    pub(super) fn assign(&self, codes: &[i8], simd: Simd) -> Vec<u32> {
        let groups = (SHARE_OF_GROUPS * self.groups() as f64).ceil() as u32;
        nearest(self.as_centres(), self.axes, codes, groups.max(LEAST_GROUPS), simd)
    }

    /// Moves every centre to the middle of its entries and makes new groups of the centres. Buckets
    /// without entries vanish.
    pub(super) fn move_centres(&mut self, codes: &[i8], homes: &[u32], simd: Simd) {
        let (ends, ids) = counting_sort(homes, self.places() as u32);
        let centres: Vec<Option<Vec<i8>>> = (0..self.places())
            .into_par_iter()
            .map(|bucket| {
                let start = bucket.checked_sub(1).map_or(0, |before| ends[before]) as usize;
                let members = &ids[start..ends[bucket] as usize];
                middle(codes, self.axes, members.iter().copied())
            })
            .collect();
        // The group that each place belongs to now.
        let mut groups: Vec<u32> = (0u32..)
            .zip(self.group_directory.windows(2))
            .flat_map(|(group, bounds)| vec![group; LANES * (bounds[1] - bounds[0]) as usize])
            .collect();
        let count = self.groups();
        let flat: Vec<i8> = centres.iter().flatten().flatten().copied().collect();
        let mut groups_of: Vec<u32> =
            groups.drain(..).zip(&centres).filter(|(_, c)| c.is_some()).map(|(g, _)| g).collect();
        for _ in 0..GROUP_ROUNDS {
            let placed =
                groups_of.iter().zip(flat.chunks_exact(self.axes)).map(|(&g, c)| (g as usize, c.to_vec()));
            *self = Self::group(self.axes, self.scale, count, placed);
            let own = self.as_centres();
            // The groups' own centres, ranked as if they were buckets of one group.
            let all = [0, own.groups.len() as u32];
            let tops = Centres { group_directory: &all, buckets: own.groups, ..own };
            groups_of = nearest(tops, self.axes, &flat, 1, simd);
        }
        let placed =
            groups_of.iter().zip(flat.chunks_exact(self.axes)).map(|(&g, c)| (g as usize, c.to_vec()));
        *self = Self::group(self.axes, self.scale, count, placed);
    }
}

/// The nearest centre, by number, for every row of codes.
fn nearest(centres: Centres<'_>, axes: usize, codes: &[i8], groups: u32, simd: Simd) -> Vec<u32> {
    let mut homes = vec![0; codes.len() / axes];
    homes.par_chunks_mut(CHUNK).zip(codes.par_chunks(CHUNK * axes)).for_each(|(homes, codes)| {
        let (mut query, mut ranking) = (QuantisedQuery::default(), Ranking::default());
        for (home, codes) in homes.iter_mut().zip(codes.chunks_exact(axes)) {
            query.set_codes(codes, centres.scale);
            centres.rank(simd, &query, groups, 1, &mut ranking);
            *home = ranking.buckets.first().map_or(0, |&(_, bucket)| bucket);
        }
    });
    homes
}

/// The mean of some rows of codes, to the nearest code; `None` of no rows. Sums of integers do not
/// depend on their order.
fn middle(codes: &[i8], axes: usize, ids: impl ExactSizeIterator<Item = u32>) -> Option<Vec<i8>> {
    let count = ids.len() as i64;
    if count == 0 {
        return None;
    }
    let mut sums = vec![0i64; axes];
    for id in ids {
        for (sum, &code) in sums.iter_mut().zip(&codes[id as usize * axes..][..axes]) {
            *sum += i64::from(code);
        }
    }
    Some(sums.iter().map(|sum| (2 * sum + count).div_euclid(2 * count) as i8).collect())
}

/// Appends centres in blocks, the last one filled up with nothing.
fn put_centres(into: &mut AlignedVec<64>, axes: usize, scale: f32, centres: &[i8]) {
    let stride = blocks::centre_stride(axes);
    for sixteen in centres.chunks(LANES * axes) {
        let start = into.len();
        into.resize(start + stride, 0);
        let mut block = BlockMut::new(&mut into[start..], axes, CodeBits::Eight);
        for lane in 0..LANES {
            match sixteen.get(lane * axes..(lane + 1) * axes) {
                Some(codes) => {
                    let squares: i32 = codes.iter().map(|&code| i32::from(code) * i32::from(code)).sum();
                    block.put(lane, codes, scale * scale * squares as f32, None);
                }
                None => block.put_nothing(lane),
            }
        }
    }
}
