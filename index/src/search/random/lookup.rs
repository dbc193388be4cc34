//! One query after another on its way through a random hash.

use super::id_set::IdSet;
use super::{Random, RandomHyperplanes};

/// Looks queries up in a random hash: [`Self::probe`] chooses the buckets, [`Self::gather`] takes
/// what they hold.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<'a> {
    hash: Random<'a>,
    /// How far the query lies from each plane of a table, and the plane's number.
    margins: Vec<(f32, usize)>,
    /// Buckets to look into, table by table, the most promising of each table first.
    buckets: Vec<u32>,
    candidates: IdSet,
}

impl<'a> Lookup<'a> {
    pub(crate) fn new(hash: Random<'a>) -> Self {
        Self { hash, margins: Vec::new(), buckets: Vec::new(), candidates: IdSet::default() }
    }

    pub(crate) fn hash(&self) -> &Random<'a> {
        &self.hash
    }

    /// Chooses `probes` buckets a table: its own first; then those across one plane, the nearest
    /// plane first.
    pub(crate) fn probe(&mut self, vector: &[f32], probes: u32) {
        let Self { hash, margins, buckets, .. } = self;
        let RandomHyperplanes { size, .. } = hash.hyperplanes;
        buckets.clear();
        for table in 0..size.tables {
            margins.clear();
            let mut bits = 0u64;
            hash.hyperplanes.margins(vector, table, |plane, margin| {
                bits |= u64::from(margin >= 0.0) << plane;
                margins.push((margin.abs(), plane));
            });
            let number = |bits: u64| table * size.buckets + hash.hyperplanes.bucket(bits, table);
            buckets.push(number(bits));
            if probes > 1 {
                margins.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let flips = margins.iter().take(probes as usize - 1);
                buckets.extend(flips.map(|(_, plane)| number(bits ^ (1 << plane))));
            }
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
    pub(crate) fn candidates(&self) -> &[u32] {
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
            lookup.probe(&[1.0], 1);
            lookup.gather();
            lookup.candidates().to_vec()
        };
        assert_eq!(gathered(&[(0, 5)]), [0]);
        assert_eq!(gathered(&[(0, 5), (70, 8)]), [0, 70, 77]);
        assert_eq!(gathered(&[(0, 2)]), [0; 0], "three in one bucket, of two");
    }
}
