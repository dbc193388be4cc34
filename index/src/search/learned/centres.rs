//! The centres of the buckets, by which buckets are ranked for a query.

use crate::search::blocks::{Blocks, QuantisedQuery};
use crate::search::simd::Simd;
use crate::search::smallest::Smallest;

/// Centres in groups, as they lie in the file. Nothing in them is trusted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Centres<'a> {
    /// The unit of the codes.
    pub(crate) scale: f32,
    /// The centres of the groups.
    pub(crate) groups: Blocks<'a>,
    /// Where the blocks of centres of each group start and end.
    pub(crate) group_directory: &'a [u32],
    /// The centres of the buckets, group by group: a bucket's number is the place of its centre.
    pub(crate) buckets: Blocks<'a>,
}

/// The buckets ranked for a query, and the memory that it takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ranking {
    nearest: Smallest,
    groups: Vec<u32>,
    /// The nearest first, each with the query's squared distance from its centre, less the query's
    /// own square: what the bucket adds to the scores of its entries.
    pub(crate) buckets: Vec<(f32, u32)>,
}

impl Centres<'_> {
    /// Ranks the buckets: the `probes` nearest of the `groups` nearest groups.
    pub(crate) fn rank(
        &self,
        simd: Simd,
        query: &QuantisedQuery,
        groups: u32,
        probes: u32,
        ranking: &mut Ranking,
    ) {
        let Ranking { nearest, groups: chosen, buckets } = ranking;
        let factor = 2.0 * self.scale * query.step;
        let all = self.group_directory.len().saturating_sub(1) as u32;
        chosen.clear();
        if groups >= all {
            chosen.extend(0..all);
        } else {
            nearest.reset(groups as usize);
            nearest.scan(simd, std::iter::once((0.0, self.groups)), query, factor);
            chosen.extend(nearest.unsorted().map(|(_, group)| group));
        }
        nearest.reset(probes as usize);
        let runs = chosen.iter().map(|&group| {
            let (start, end) = bounds(self.group_directory, group);
            (0.0, self.buckets.run(start, end))
        });
        nearest.scan(simd, at_most(self.buckets, runs), query, factor);
        buckets.clear();
        buckets.extend(nearest.sorted());
    }
}

/// Where the blocks of one number start and end; nowhere where the directory makes no sense.
pub(super) fn bounds(directory: &[u32], number: u32) -> (u32, u32) {
    let bounds = directory.get(number as usize).zip(directory.get(number as usize + 1));
    bounds.map_or((0, 0), |(&start, &end)| (start, end))
}

/// Runs of the blocks of a file, `all`, as long as they are no more than these together: in none
/// that is sound do two runs share a block, and in a hostile one each may be the whole file.
pub(super) fn at_most<'a>(
    all: Blocks<'a>,
    runs: impl Iterator<Item = (f32, Blocks<'a>)> + Clone,
) -> impl Iterator<Item = (f32, Blocks<'a>)> + Clone {
    let mut left = all.bytes().len();
    runs.take_while(move |(_, run)| {
        let rest = left.checked_sub(run.bytes().len());
        left = rest.unwrap_or(0);
        rest.is_some()
    })
}
