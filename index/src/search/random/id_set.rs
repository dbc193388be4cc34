//! A set of ids that is emptied in time linear in what it holds.

/// Ids, each once, in the order in which they came. One bit for each possible id, so that asking
/// whether one is in costs nothing; those bits alone are cleared that were set, because a query
/// meets a small share of a large index.
#[derive(Clone, Debug, Default)]
pub(super) struct IdSet {
    bits: Vec<u64>,
    ids: Vec<u32>,
}

impl IdSet {
    /// Removes all ids and makes room for those below `limit`.
    pub(super) fn clear(&mut self, limit: usize) {
        for &id in &self.ids {
            if let Some(word) = self.bits.get_mut(id as usize / 64) {
                *word = 0;
            }
        }
        self.ids.clear();
        let words = limit.div_ceil(64);
        if self.bits.len() < words {
            self.bits.resize(words, 0);
        }
    }

    /// Adds an id, unless it is in already or there is no room for it.
    #[inline]
    pub(super) fn insert(&mut self, id: u32) {
        let bit = 1u64 << (id % 64);
        if let Some(word) = self.bits.get_mut(id as usize / 64).filter(|word| **word & bit == 0) {
            *word |= bit;
            self.ids.push(id);
        }
    }

    pub(super) fn ids(&self) -> &[u32] {
        &self.ids
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn holds_each_id_once_and_none_of_before(rounds in prop::collection::vec(prop::collection::vec(0..300u32, 0..80), 1..5)) {
            let mut set = IdSet::default();
            for ids in rounds {
                set.clear(256);
                ids.iter().for_each(|&id| set.insert(id));
                let mut expected: Vec<u32> = Vec::new();
                for id in ids {
                    if id < 256 && !expected.contains(&id) {
                        expected.push(id);
                    }
                }
                prop_assert_eq!(set.ids(), expected);
            }
        }
    }
}
