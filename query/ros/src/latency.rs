//! How long answers take.

use std::fmt;
use std::time::Duration;

/// As many of the last times are kept: six minutes of 30 pictures a second.
const KEPT: usize = 10_800;

/// The last times of many.
#[derive(Debug, Default)]
pub(crate) struct Latencies {
    times: Vec<Duration>,
    /// How many there ever were.
    count: usize,
}

impl Latencies {
    /// Adds a time.
    pub(crate) fn add(&mut self, time: Duration) {
        let at = self.count % KEPT;
        match self.times.get_mut(at) {
            Some(oldest) => *oldest = time,
            None => self.times.push(time),
        }
        self.count += 1;
    }

    /// The time that this share (0..=1) of those kept are not above; `None` where there is none.
    pub(crate) fn quantile(&self, share: f64) -> Option<Duration> {
        let mut sorted = self.times.clone();
        sorted.sort_unstable();
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.max(1) - 1).copied()
    }
}

impl fmt::Display for Latencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let milliseconds = |share| self.quantile(share).map(|time| 1e3 * time.as_secs_f64());
        match (milliseconds(0.5), milliseconds(0.99)) {
            (Some(p50), Some(p99)) => write!(f, "p50 {p50:.1} ms, p99 {p99:.1} ms"),
            _ => f.write_str("not measured"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_times_that_were_measured() {
        let mut times = Latencies::default();
        assert_eq!(times.to_string(), "not measured");
        (1..=100).rev().for_each(|number| times.add(Duration::from_millis(number)));
        assert_eq!(times.to_string(), "p50 50.0 ms, p99 99.0 ms");
        assert_eq!(times.quantile(1.0), Some(Duration::from_millis(100)));
    }

    #[test]
    fn the_oldest_are_forgotten() {
        let mut times = Latencies::default();
        times.add(Duration::from_secs(1));
        (0..KEPT).for_each(|_| times.add(Duration::ZERO));
        assert_eq!((times.quantile(1.0), times.times.len()), (Some(Duration::ZERO), KEPT));
    }
}
