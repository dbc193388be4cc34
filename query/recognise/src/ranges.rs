//! What the options of recognition may be: each program that takes them from its users, on a
//! command line, in a request or as parameters, refuses what is not in these ranges. No NaN is.

use std::ops::{Bound, RangeInclusive};

/// [`RecogniseOptions::rolls`](crate::RecogniseOptions::rolls): up to one a degree.
pub const ROLLS: RangeInclusive<usize> = 1..=360;
/// [`RecogniseOptions::k`](crate::RecogniseOptions::k), and the neighbours of a search.
pub const NEIGHBOURS: RangeInclusive<usize> = 1..=100_000;
/// The widths of [`VoteOptions`](grasp_index::VoteOptions), and the distance of
/// [`Accept::Within`](crate::Accept::Within): above 0, finite.
pub const POSITIVE: (Bound<f64>, Bound<f64>) = (Bound::Excluded(0.0), Bound::Excluded(f64::INFINITY));
/// The recall and the success of an [`Effort`](grasp_index::Effort): above 0, at most 1.
pub const RECALL: (Bound<f64>, Bound<f64>) = (Bound::Excluded(0.0), Bound::Included(1.0));
/// The eps of an [`Effort`](grasp_index::Effort): 0 or more, finite.
pub const EPS: (Bound<f64>, Bound<f64>) = (Bound::Included(0.0), Bound::Excluded(f64::INFINITY));
/// The probes of an [`Effort`](grasp_index::Effort), before they are cut to an index's buckets.
pub const PROBES: RangeInclusive<u32> = 1..=u32::MAX;
/// [`SequenceParams::switch`](crate::sequence::SequenceParams::switch), as any probability.
pub const PROBABILITY: RangeInclusive<f64> = 0.0..=1.0;
/// [`SequenceParams::motion_deg`](crate::sequence::SequenceParams::motion_deg).
pub const MOTION_DEG: RangeInclusive<f64> = 0.0..=180.0;
