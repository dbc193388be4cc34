//! What is known about an index, as records for JSON: once for `grasp-builder inspect --json`, the
//! service and the Python package.
//!
//! The keys are an interface: they may be added to, never renamed.
//!
//! [`IndexInfo`] is all of it; [`EffortInfo`] and [`HashInfo`] are parts that the service
//! reports by themselves.

mod index;
mod search;
mod vote;

pub use index::{ClassCount, DescriptorInfo, IndexInfo, Provenance, SectionInfo, SigmaInfo, class_counts};
pub use search::{EffortInfo, HashInfo, MeasuredInfo};
pub use vote::{MeasuredVote, ReliabilityInfo, VoteInfo};
