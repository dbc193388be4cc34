//! How long the steps of a recognition took.

use std::time::Instant;

use serde::Serialize;

/// Milliseconds of each step, summed over all hands and rolls that were tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Timings {
    /// Bytes to pixels.
    pub decode_ms: f64,
    /// Pixels to the hand's mask.
    pub segmentation_ms: f64,
    /// Mask to hand images and descriptors.
    pub descriptor_ms: f64,
    /// Descriptors to neighbours.
    pub search_ms: f64,
    /// Neighbours to class and orientation.
    pub vote_ms: f64,
}

impl Timings {
    /// Runs `work` and adds its time to the step that `step` picks.
    pub(crate) fn time<T>(&mut self, step: impl Fn(&mut Self) -> &mut f64, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let result = work();
        *step(self) += milliseconds(started);
        result
    }

    /// The sum of all steps, in milliseconds.
    pub fn total_ms(&self) -> f64 {
        self.decode_ms + self.segmentation_ms + self.descriptor_ms + self.search_ms + self.vote_ms
    }
}

pub(super) fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
