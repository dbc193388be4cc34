//! One hash whose buckets lie in several files.

use super::Hash;
use super::exact::Nearest;
use super::searcher::Scratch;
use super::simd::Simd;

/// Hashes that were learned as one: a bucket's entries are those of the bucket of that number in each. So what is looked at, and what
/// is kept of it, is what a single file of all entries would give.
pub(crate) struct Joined<'a> {
    first: Box<dyn Hash + 'a>,
    /// Each with the number of its first entry.
    others: Vec<(u32, Box<dyn Hash + 'a>)>,
}

impl<'a> Joined<'a> {
    /// Of `first`, whose entries are numbered from 0, and others, each with the number of its first entry, ascending.
    pub(crate) fn new(first: Box<dyn Hash + 'a>, others: Vec<(u32, Box<dyn Hash + 'a>)>) -> Self {
        Self { first, others }
    }
}

impl Hash for Joined<'_> {
    fn tables(&self) -> u32 {
        self.first.tables()
    }

    fn most_probes(&self) -> u32 {
        self.first.most_probes()
    }

    fn probe(&self, simd: Simd, vector: &[f32], probes: u32, scratch: &mut Scratch) {
        self.first.probe(simd, vector, probes, scratch);
    }

    fn parts(&self, scratch: &Scratch, each: &mut dyn FnMut(&[u8])) {
        self.first.parts(scratch, each);
        self.others.iter().for_each(|(_, hash)| hash.parts(scratch, each));
    }

    fn prefetch(&self, scratch: &Scratch) {
        self.first.prefetch(scratch);
        self.others.iter().for_each(|(_, hash)| hash.prefetch(scratch));
    }

    fn begin(&self, k: usize, scratch: &mut Scratch) {
        self.first.begin(k, scratch);
    }

    fn scan(&self, simd: Simd, first: u32, scratch: &mut Scratch) {
        self.first.scan(simd, first, scratch);
        for (start, hash) in &self.others {
            hash.scan(simd, first.wrapping_add(*start), scratch);
        }
    }

    fn end(&self, scratch: &mut Scratch) {
        self.first.end(scratch);
    }

    fn held(&self, first: u32, scratch: &Scratch) -> u32 {
        let others = self.others.iter().map(|(start, hash)| hash.held(first.wrapping_add(*start), scratch));
        others.fold(self.first.held(first, scratch), u32::saturating_add)
    }

    fn keys(&self, scratch: &mut Scratch, each: &mut dyn FnMut(u32, u32)) -> Option<usize> {
        self.first.keys(scratch, each)
    }

    fn estimate(&self, scratch: &mut Scratch, nearest: &mut Nearest) {
        self.first.estimate(scratch, nearest);
    }
}
