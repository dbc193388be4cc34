//! The steps of one search by the learned hash, each by itself, for the benches to time. No part of the interface.

use super::Hash;
use super::learned::Learned;
use super::searcher::{Scratch, rerank};
use super::simd::Simd;
use super::stored::Stored;

/// One query on its way through an index, on one of the machine's paths.
#[derive(Debug)]
pub struct Parts<'a> {
    stored: Stored<'a>,
    learned: Learned<'a>,
    simd: Simd,
    scratch: Scratch,
}

impl<'a> Parts<'a> {
    pub(crate) fn new(stored: Stored<'a>, learned: Learned<'a>, simd: Simd) -> Self {
        Self { stored, learned, simd, scratch: Scratch::default() }
    }

    /// The instructions that are used.
    pub fn path(&self) -> &'static str {
        self.simd.name()
    }

    /// Into the principal axes, and quantised.
    pub fn rotate(&mut self, query: &[f32]) {
        self.learned.rotate(self.simd, query, &mut self.scratch);
    }

    /// The `probes` buckets whose centres are nearest to the rotated query.
    pub fn rank(&mut self, probes: u32) {
        self.learned.rank(self.simd, self.learned.groups_for(probes), probes, &mut self.scratch);
    }

    /// How many entries the ranked buckets hold.
    pub fn held(&self) -> u32 {
        self.learned.held(0, &self.scratch)
    }

    /// The best by their codes of the entries of the ranked buckets.
    pub fn scan(&mut self, k: usize) {
        self.learned.gather(self.simd, k, &mut self.scratch);
    }

    /// Measures those, and keeps the k nearest; returns how many were measured.
    pub fn rerank(&mut self, query: &[f32], k: usize) -> usize {
        rerank(self.stored, &self.learned, self.simd, query, k, &mut self.scratch);
        self.scratch.candidates.len()
    }
}
