//! What a build did.

use std::time::Duration;

use grasp_index::Summary;

/// What a build did.
#[derive(Debug)]
pub struct Report {
    /// The written index; `None` where the existing file was up to date and was left alone.
    pub written: Option<Summary>,
    /// Entries of the index.
    pub entries: usize,
    /// Entries whose picture was known to the existing index.
    pub reused: usize,
    /// Pictures that show no hand (a view in which the object hides it) and make no entry.
    pub without_hand: usize,
    /// How long it took.
    pub elapsed: Duration,
}
