//! From a descriptor to its nearest neighbours (the paper's Section V).
//!
//! The seam is [`hash`]: a hash turns a vector into an ordered list of buckets to probe, and its
//! buckets give candidates. What follows is one path for every hash ([`in_flight`]): the
//! candidates' distances are measured by their descriptors, and the k nearest kept ([`nearest`]).
//! [`searcher`] is the door to it all.
//!
//! - [`random`] is the paper's hash, with K and T learned from the data.
//! - [`learned`] fits the hyperplanes themselves to the data, and scans its buckets by short codes
//!   ([`blocks`], [`simd`]).
//! - [`exact`] measures every row.
//! - [`build`] makes a hash; [`measure`] finds out how many probes find how much ([`effort`]), so
//!   that a search is asked for what to find, not how.
//!
//! This file declares the parts and names what others use of them; the parts name each other, never
//! this file.

pub(crate) mod blocks;
pub(crate) mod build;
mod counting_sort;
pub(crate) mod distance;
pub(crate) mod effort;
mod exact;
pub(crate) mod hash;
mod in_flight;
pub(crate) mod learned;
mod measure;
mod nearest;
mod options;
mod originals;
#[cfg(feature = "parts")]
pub(crate) mod parts;
pub(crate) mod queries;
pub(crate) mod random;
mod read_ahead;
mod result;
mod rows;
pub(crate) mod searcher;
pub(crate) mod simd;
pub(crate) mod smallest;
pub(crate) mod stored;

pub(crate) use hash::Hash;
pub use nearest::Neighbour;
pub use options::{Effort, SearchError, SearchOptions};
pub use originals::Originals;
pub(crate) use read_ahead::ReadAhead;
pub use result::{Search, SearchCost, Shortlist};
pub(crate) use rows::{Rows, Source};

#[cfg(test)]
mod tests;
