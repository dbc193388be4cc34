//! What the building of an index is at.

/// What finishing an index is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Measuring sigma.
    Sigma,
    /// Choosing the hash.
    Tune,
    /// Fitting the hash and putting every entry into its buckets.
    Tables,
    /// Measuring the search.
    Measure,
    /// Calibrating the vote.
    Calibrate,
    /// Writing the file.
    Write,
}
