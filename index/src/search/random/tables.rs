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
        // In their places from the beginning: a directory of many tables of many buckets is what
        // takes the memory, however few the rows are.
        let (per_table, count) = (buckets as usize, rows.len());
        let mut directory = vec![0; tables as usize * per_table + 1];
        let mut ids = vec![0; tables as usize * count];
        let places = directory[1..].par_chunks_exact_mut(per_table).zip(ids.par_chunks_exact_mut(count));
        places.zip(0..tables).for_each(|((directory, ids), table)| {
            let homes: Vec<u32> =
                rows.values.par_chunks_exact(rows.dim).map(|row| bucket_of(row, table)).collect();
            let (ends, sorted) = counting_sort(&homes, buckets);
            let start = table * count as u32;
            directory.iter_mut().zip(ends).for_each(|(place, end)| *place = start + end);
            ids.copy_from_slice(&sorted);
        });
        Self { directory, ids }
    }

    pub(crate) fn as_buckets(&self) -> Buckets<'_> {
        Buckets { directory: &self.directory, ids: &self.ids }
    }
}
