//! Ids sorted by bucket, in time linear in their number.

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
