//! The tables' buckets, all in two flat arrays: bucket `b` holds `ids[directory[b]..directory[b +
//! 1]]`. Bucket `h` of table `t` is number `t * H + h`.

use crate::search::counting_sort::counting_sort;
use crate::search::rows::Rows;
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

/// Buckets on their way into a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tables {
    pub(crate) directory: Vec<u32>,
    pub(crate) ids: Vec<u32>,
}

impl Tables {
    /// Puts every row into one bucket of each of `tables` tables of `buckets` buckets: the one that
    /// `bucket_of(row, table)`, below `buckets`, names. Within a bucket ids ascend. `tables * rows`
    /// must fit a `u32`.
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
