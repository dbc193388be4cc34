//! The steps of one search by the learned hash, each by itself, for the benches to time. No part of
//! the interface.

use super::learned::Learned;
use super::learned::lookup::Lookup;
use super::nearest::Nearest;
use super::simd::Simd;
use super::stored::Stored;

/// One query on its way through an index, on one of the machine's paths.
#[derive(Debug)]
pub struct Parts<'a> {
    stored: Stored<'a>,
    simd: Simd,
    lookup: Lookup<'a>,
    nearest: Nearest,
    row: Vec<f32>,
}

impl<'a> Parts<'a> {
    pub(crate) fn new(stored: Stored<'a>, learned: Learned<'a>, simd: Simd) -> Self {
        Self { stored, simd, lookup: Lookup::new(learned), nearest: Nearest::default(), row: Vec::new() }
    }

    /// The instructions that are used.
    pub fn path(&self) -> &'static str {
        self.simd.name()
    }

    /// Into the principal axes, and quantised.
    pub fn rotate(&mut self, query: &[f32]) {
        self.lookup.rotate(self.simd, query);
    }

    /// The `probes` buckets whose centres are nearest to the rotated query.
    pub fn rank(&mut self, probes: u32) {
        self.lookup.rank(self.simd, probes);
    }

    /// How many entries the ranked buckets hold.
    pub fn held(&self) -> u32 {
        self.lookup.held()
    }

    /// The best by their codes of the entries of the ranked buckets.
    pub fn scan(&mut self, k: usize) {
        self.lookup.gather(self.simd, k);
    }

    /// Measures those, and keeps the k nearest; returns how many were measured.
    pub fn rerank(&mut self, query: &[f32], k: usize) -> usize {
        self.nearest.reset(k);
        let candidates = self.lookup.shortlist();
        self.stored.measure(self.simd, query, candidates, &mut self.row, &mut self.nearest);
        candidates.len()
    }
}
