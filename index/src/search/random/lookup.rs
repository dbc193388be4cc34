//! One query after another on its way through a random hash.

use super::id_set::IdSet;
use super::{Random, RandomHyperplanes};

/// A query as the hyperplanes see it, however many buckets are looked into.
#[derive(Clone, Debug, Default)]
pub(crate) struct Located {
    /// Its bit string in each table.
    bits: Vec<u64>,
    /// The numbers of each table's planes, the nearest first, table by table.
    nearest: Vec<u8>,
}

/// Looks queries up in a random hash: [`Self::locate`] takes a query up, [`Self::rank`] chooses the
/// buckets, [`Self::gather`] takes what they hold.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<'a> {
    hash: Random<'a>,
    /// How far the query lies from each plane of a table, and the plane's number.
    margins: Vec<(f32, u8)>,
    pub(crate) query: Located,
    /// Buckets to look into, table by table, the most promising of each table first.
    buckets: Vec<u32>,
    candidates: IdSet,
}

impl<'a> Lookup<'a> {
    pub(crate) fn new(hash: Random<'a>) -> Self {
        Self {
            hash,
            margins: Vec::new(),
            query: Located::default(),
            buckets: Vec::new(),
            candidates: IdSet::default(),
        }
    }

    pub(crate) fn hash(&self) -> &Random<'a> {
        &self.hash
    }

    /// Takes up a query: on which side of each plane it lies, and which planes are near.
    pub(crate) fn locate(&mut self, vector: &[f32]) {
        let Self { hash, margins, query: Located { bits: all_bits, nearest }, .. } = self;
        all_bits.clear();
        nearest.clear();
        for table in 0..hash.tables() {
            margins.clear();
            let mut bits = 0u64;
            hash.hyperplanes.margins(vector, table, |plane, margin| {
                bits |= u64::from(margin >= 0.0) << plane;
                margins.push((margin.abs(), plane as u8));
            });
            all_bits.push(bits);
            margins.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            nearest.extend(margins.iter().map(|(_, plane)| plane));
        }
    }

    /// Chooses `probes` buckets a table for the located query: its own first; then those across one
    /// plane, the nearest plane first.
    pub(crate) fn rank(&mut self, probes: u32) {
        let Self { hash, query, buckets, .. } = self;
        let RandomHyperplanes { size, .. } = hash.hyperplanes;
        buckets.clear();
        let tables = query.bits.iter().zip(query.nearest.chunks_exact(size.planes as usize));
        for (table, (&bits, nearest)) in (0..).zip(tables) {
            let number = |bits: u64| table * size.buckets + hash.hyperplanes.bucket(bits, table);
            buckets.push(number(bits));
            let flips = nearest.iter().take(probes.saturating_sub(1) as usize);
            buckets.extend(flips.map(|plane| number(bits ^ (1 << plane))));
        }
    }

    /// Takes the union of the chosen buckets. Ids past the last entry, as a damaged file may hold,
    /// are left out, and buckets of more ids than there are entries.
    pub(crate) fn gather(&mut self) {
        let ends = self.hash.files.iter().map(|file| (file.first as usize).saturating_add(file.count));
        self.candidates.clear(ends.max().unwrap_or_default());
        for file in &self.hash.files {
            for &bucket in &self.buckets {
                let ids = file.buckets.get(bucket);
                if ids.len() <= file.count {
                    let ids = ids.iter().filter(|&&id| (id as usize) < file.count);
                    ids.for_each(|id| self.candidates.insert(file.first.wrapping_add(*id)));
                }
            }
        }
    }

    /// How many buckets were chosen.
    pub(crate) fn buckets(&self) -> usize {
        self.buckets.len()
    }

    /// The entries that the buckets hold, each once.
    pub(crate) fn shortlist(&self) -> &[u32] {
        self.candidates.ids()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::Buckets;
    use super::super::{Entries, RandomHash};
    use super::*;

    #[test]
    fn ids_past_the_last_row_are_left_out_and_files_are_numbered_on() {
        let buckets = Buckets { directory: &[0, 3], ids: &[0, 7, u32::MAX] };
        let hash = |files: &[(u32, usize)]| Random {
            hyperplanes: RandomHyperplanes {
                size: RandomHash { planes: 1, tables: 1, buckets: 1 },
                dim: 1,
                normals: &[1.0],
                offsets: &[0.0],
            },
            files: files.iter().map(|&(first, count)| Entries { buckets, count, first }).collect(),
        };
        let gathered = |files: &[(u32, usize)]| {
            let mut lookup = Lookup::new(hash(files));
            lookup.locate(&[1.0]);
            lookup.rank(1);
            lookup.gather();
            lookup.shortlist().to_vec()
        };
        assert_eq!(gathered(&[(0, 5)]), [0]);
        assert_eq!(gathered(&[(0, 5), (70, 8)]), [0, 70, 77]);
        assert_eq!(gathered(&[(0, 2)]), [0; 0], "three in one bucket, of two");
    }
}
