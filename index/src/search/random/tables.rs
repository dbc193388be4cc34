//! The tables' buckets, all in two flat arrays: bucket `b` holds `ids[directory[b]..directory[b + 1]]`. Bucket `h` of
//! table `t` is number `t * H + h`.

use crate::search::Rows;
use rayon::prelude::*;

/// Buckets as they lie in the file. Nothing in them is trusted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Buckets<'a> {
    pub(crate) directory: &'a [u32],
    pub(crate) ids: &'a [u32],
}

impl<'a> Buckets<'a> {
    /// The ids in bucket `bucket`: none where the directory makes no sense.
    pub(crate) fn get(&self, bucket: u32) -> &'a [u32] {
        let bounds = self.directory.get(bucket as usize).zip(self.directory.get(bucket as usize + 1));
        bounds.and_then(|(&start, &end)| self.ids.get(start as usize..end as usize)).unwrap_or(&[])
    }
}

/// Adds to `union` the ids below `rows` in any of the buckets, each once, in the order they are met, numbered on from `first`.
/// `met` has a bit for each id that was met, by those numbers.
pub(crate) fn union(
    buckets: Buckets<'_>,
    probed: impl Iterator<Item = u32>,
    first: u32,
    rows: usize,
    met: &mut Vec<u64>,
    union: &mut Vec<u32>,
) {
    let words = (first as usize).saturating_add(rows).div_ceil(64);
    if met.len() < words {
        met.resize(words, 0);
    }
    for bucket in probed {
        for id in buckets.get(bucket).iter().filter(|&&id| (id as usize) < rows) {
            let id = first.wrapping_add(*id);
            let (word, bit) = (id as usize / 64, 1u64 << (id % 64));
            if let Some(word) = met.get_mut(word).filter(|word| **word & bit == 0) {
                *word |= bit;
                union.push(id);
            }
        }
    }
}

/// Buckets on their way into a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tables {
    pub(crate) directory: Vec<u32>,
    pub(crate) ids: Vec<u32>,
}

impl Tables {
    /// Puts every row into one bucket of each of `tables` tables of `buckets` buckets: the one that `bucket_of(row, table)`,
    /// below `buckets`, names. Within a bucket ids ascend. `tables * rows` must fit a `u32`.
    pub(crate) fn build(
        rows: Rows<'_>,
        tables: u32,
        buckets: u32,
        bucket_of: impl Fn(&[f32], u32) -> u32 + Sync,
    ) -> Self {
        let sorted: Vec<(Vec<u32>, Vec<u32>)> = (0..tables)
            .into_par_iter()
            .map(|table| {
                let homes: Vec<u32> =
                    rows.values.par_chunks_exact(rows.dim).map(|row| bucket_of(row, table)).collect();
                counting_sort(&homes, buckets)
            })
            .collect();
        let mut all = Self { directory: vec![0], ids: Vec::with_capacity(tables as usize * rows.len()) };
        for (ends, ids) in sorted {
            let start = all.ids.len() as u32;
            all.directory.extend(ends.iter().map(|end| start + end));
            all.ids.extend(ids);
        }
        all
    }

    pub(crate) fn as_buckets(&self) -> Buckets<'_> {
        Buckets { directory: &self.directory, ids: &self.ids }
    }
}

/// The end of each bucket, and the ids by bucket.
pub(crate) fn counting_sort(homes: &[u32], buckets: u32) -> (Vec<u32>, Vec<u32>) {
    let mut next = vec![0u32; buckets as usize + 1];
    for &home in homes {
        next[home as usize + 1] += 1;
    }
    for bucket in 0..buckets as usize {
        next[bucket + 1] += next[bucket];
    }
    let ends = next[1..].to_vec();
    let mut ids = vec![0u32; homes.len()];
    for (id, &home) in (0u32..).zip(homes) {
        ids[next[home as usize] as usize] = id;
        next[home as usize] += 1;
    }
    (ends, ids)
}
