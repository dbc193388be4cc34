//! What is counted, in the text form that Prometheus reads.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use grasp_recognise::Timings;

/// Upper bounds in seconds: from a search over descriptors to a picture that waited.
const SECONDS: [f64; 14] =
    [0.000_02, 0.000_05, 0.000_1, 0.000_2, 0.000_5, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0];
/// Upper bounds of candidates.
const COUNTS: [f64; 10] = [100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 1e5, 1e6, 1e7];

/// How many values lie below each bound.
#[derive(Debug)]
struct Histogram {
    bounds: &'static [f64],
    /// One more than bounds: the last counts what lies above all.
    counts: Vec<AtomicU64>,
    /// In millionths of the unit: whole numbers can be added without a lock.
    sum_millionths: AtomicU64,
}

impl Histogram {
    fn new(bounds: &'static [f64]) -> Self {
        let counts = (0..=bounds.len()).map(|_| AtomicU64::new(0)).collect();
        Self { bounds, counts, sum_millionths: AtomicU64::new(0) }
    }

    fn add(&self, value: f64) {
        let at = self.bounds.partition_point(|&bound| bound < value);
        if let Some(count) = self.counts.get(at) {
            count.fetch_add(1, Ordering::Relaxed);
        }
        self.sum_millionths.fetch_add((value * 1e6).round().max(0.0) as u64, Ordering::Relaxed);
    }

    /// `labels` is empty or ends in a comma.
    fn write(&self, out: &mut String, name: &str, labels: &str) {
        let mut below = 0;
        for (at, count) in self.counts.iter().enumerate() {
            below += count.load(Ordering::Relaxed);
            let bound = self.bounds.get(at).map_or_else(|| "+Inf".to_owned(), f64::to_string);
            let _ = writeln!(out, "{name}_bucket{{{labels}le=\"{bound}\"}} {below}");
        }
        let only = labels.trim_end_matches(',');
        let only = if only.is_empty() { String::new() } else { format!("{{{only}}}") };
        let sum = self.sum_millionths.load(Ordering::Relaxed) as f64 / 1e6;
        let _ = writeln!(out, "{name}_sum{only} {sum}\n{name}_count{only} {below}");
    }
}

/// The paths that are told apart; everything else is the page.
pub(super) const PATHS: [&str; 6] =
    ["/v1/recognise", "/v1/search", "/v1/strategy", "/v1/index", "/v1/neighbours", "other"];
const STEPS: [&str; 5] = ["decode", "segmentation", "descriptor", "search", "vote"];

/// All that is counted since the start.
#[derive(Debug)]
pub(super) struct Metrics {
    /// How many answers of each status each path gave.
    answers: Mutex<BTreeMap<(&'static str, u16), u64>>,
    seconds: Vec<(&'static str, Histogram)>,
    steps: Vec<(&'static str, Histogram)>,
    candidates: Histogram,
    panics: AtomicU64,
}

/// What is so at this moment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Now {
    pub(super) generation: u64,
    pub(super) entries: u64,
    pub(super) reload_failures: u64,
    pub(super) index_is_stale: bool,
    pub(super) arriving: usize,
    /// Bytes that large bodies have reserved.
    pub(super) reserved: usize,
    pub(super) inside: usize,
    pub(super) ready: bool,
}

impl Default for Metrics {
    fn default() -> Self {
        let histograms =
            |names: &[&'static str]| names.iter().map(|&name| (name, Histogram::new(&SECONDS))).collect();
        Self {
            answers: Mutex::default(),
            seconds: histograms(&PATHS),
            steps: histograms(&STEPS),
            candidates: Histogram::new(&COUNTS),
            panics: AtomicU64::new(0),
        }
    }
}

impl Metrics {
    pub(super) fn answered(&self, path: &'static str, status: u16, took: Duration) {
        *self.answers.lock().unwrap_or_else(PoisonError::into_inner).entry((path, status)).or_default() += 1;
        if let Some((_, histogram)) = self.seconds.iter().find(|(name, _)| *name == path) {
            histogram.add(took.as_secs_f64());
        }
    }

    pub(super) fn recognised(&self, timings: &Timings, candidates: u32) {
        let Timings { decode_ms, segmentation_ms, descriptor_ms, search_ms, vote_ms, .. } = *timings;
        let each = [decode_ms, segmentation_ms, descriptor_ms, search_ms, vote_ms];
        for ((_, histogram), milliseconds) in self.steps.iter().zip(each) {
            histogram.add(milliseconds / 1e3);
        }
        self.candidates.add(f64::from(candidates));
    }

    pub(super) fn panicked(&self) {
        self.panics.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn text(&self, now: Now) -> String {
        let mut out = String::new();
        let head = |out: &mut String, name: &str, kind: &str, help: &str| {
            let _ = writeln!(out, "# HELP {name} {help}\n# TYPE {name} {kind}");
        };
        head(&mut out, "grasp_requests_total", "counter", "Requests that were answered, by path and status.");
        for ((path, status), count) in self.answers.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            let _ = writeln!(out, "grasp_requests_total{{path=\"{path}\",status=\"{status}\"}} {count}");
        }
        head(&mut out, "grasp_request_seconds", "histogram", "From a request's head to its answer, by path.");
        for (path, histogram) in &self.seconds {
            histogram.write(&mut out, "grasp_request_seconds", &format!("path=\"{path}\","));
        }
        head(&mut out, "grasp_step_seconds", "histogram", "How long the steps of a recognition took.");
        for (step, histogram) in &self.steps {
            histogram.write(&mut out, "grasp_step_seconds", &format!("step=\"{step}\","));
        }
        head(
            &mut out,
            "grasp_candidates",
            "histogram",
            "Entries whose distance a picture's search measured.",
        );
        self.candidates.write(&mut out, "grasp_candidates", "");
        let numbers = [
            ("grasp_index_generation", "gauge", "The index that is served, counted from 1.", now.generation),
            ("grasp_index_entries", "gauge", "Entries of the index that is served.", now.entries),
            (
                "grasp_index_reload_failures_total",
                "counter",
                "New index files that could not be used.",
                now.reload_failures,
            ),
            (
                "grasp_index_stale",
                "gauge",
                "1 where the file at the index's path cannot be used, and an earlier one is served.",
                now.index_is_stale.into(),
            ),
            ("grasp_requests_arriving", "gauge", "Requests whose bodies are under way.", now.arriving as u64),
            (
                "grasp_body_bytes_reserved",
                "gauge",
                "Bytes that large bodies hold or will hold.",
                now.reserved as u64,
            ),
            ("grasp_requests_inside", "gauge", "Requests that are worked on or wait.", now.inside as u64),
            ("grasp_ready", "gauge", "1 where requests are answered.", now.ready.into()),
            (
                "grasp_panics_total",
                "counter",
                "Requests that ended in a fault of the program.",
                self.panics.load(Ordering::Relaxed),
            ),
        ];
        for (name, kind, help, value) in numbers {
            head(&mut out, name, kind, help);
            let _ = writeln!(out, "{name} {value}");
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_count_what_lies_at_or_below_their_bounds() {
        let metrics = Metrics::default();
        metrics.answered("/v1/search", 200, Duration::from_millis(5));
        metrics.answered("/v1/search", 200, Duration::from_secs(60));
        metrics.recognised(&Timings { search_ms: 0.03, ..Timings::default() }, 150);
        let text = metrics.text(Now { generation: 3, ready: true, ..Now::default() });
        for line in [
            "grasp_requests_total{path=\"/v1/search\",status=\"200\"} 2",
            "grasp_request_seconds_bucket{path=\"/v1/search\",le=\"0.002\"} 0",
            "grasp_request_seconds_bucket{path=\"/v1/search\",le=\"0.005\"} 1",
            "grasp_request_seconds_bucket{path=\"/v1/search\",le=\"+Inf\"} 2",
            "grasp_request_seconds_sum{path=\"/v1/search\"} 60.005",
            "grasp_step_seconds_bucket{step=\"search\",le=\"0.00002\"} 0",
            "grasp_step_seconds_bucket{step=\"search\",le=\"0.00005\"} 1",
            "grasp_candidates_bucket{le=\"200\"} 1",
            "grasp_candidates_count 1",
            "grasp_index_generation 3",
            "grasp_ready 1",
        ] {
            assert!(text.lines().any(|found| found == line), "{line} is missing from\n{text}");
        }
    }
}
