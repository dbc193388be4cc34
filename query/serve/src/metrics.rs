//! What is counted, in the text form of OpenMetrics, which Prometheus reads.

use std::time::Duration;

use grasp_recognise::Timings;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::{ConstCounter, Counter};
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

/// Upper bounds in seconds: from a search over descriptors to a picture that waited.
const SECONDS: [f64; 14] =
    [0.000_02, 0.000_05, 0.000_1, 0.000_2, 0.000_5, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0];
/// Upper bounds of candidates.
const COUNTS: [f64; 10] = [100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 1e5, 1e6, 1e7];

/// What [`Metrics::text`] is written in.
pub(super) const CONTENT_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// The paths that are counted by themselves, and what all others are counted as.
pub(super) const PATHS: [&str; 6] =
    ["/v1/recognise", "/v1/search", "/v1/strategy", "/v1/index", "/v1/neighbours", "other"];

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    path: &'static str,
    status: u16,
}

/// A histogram of seconds for each value of one label.
type Seconds = Family<[(&'static str, &'static str); 1], Histogram, fn() -> Histogram>;

/// All that is counted since the start.
#[derive(Debug)]
pub(super) struct Metrics {
    /// How many answers of each status each path gave.
    answers: Family<Answered, Counter>,
    seconds: Seconds,
    steps: Seconds,
    candidates: Histogram,
    panics: Counter,
}

/// What is so at this moment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gauges {
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
        let seconds = || Seconds::new_with_constructor(|| Histogram::new(SECONDS));
        let metrics = Self {
            answers: Family::default(),
            seconds: seconds(),
            steps: seconds(),
            candidates: Histogram::new(COUNTS),
            panics: Counter::default(),
        };
        // Those that nothing has happened to yet are shown, too.
        for path in PATHS {
            drop(metrics.seconds.get_or_create(&[("path", path)]));
        }
        metrics.add_steps(&Timings::default(), |_, _| {});
        metrics
    }
}

impl Metrics {
    pub(super) fn answered(&self, path: &'static str, status: u16, took: Duration) {
        self.answers.get_or_create(&Answered { path, status }).inc();
        self.seconds.get_or_create(&[("path", path)]).observe(took.as_secs_f64());
    }

    pub(super) fn recognised(&self, timings: &Timings, candidates: u32) {
        self.add_steps(timings, Histogram::observe);
        self.candidates.observe(f64::from(candidates));
    }

    fn add_steps(&self, timings: &Timings, add: impl Fn(&Histogram, f64)) {
        let Timings { decode_ms, segmentation_ms, descriptor_ms, search_ms, vote_ms, .. } = *timings;
        for (step, milliseconds) in [
            ("decode", decode_ms),
            ("segmentation", segmentation_ms),
            ("descriptor", descriptor_ms),
            ("search", search_ms),
            ("vote", vote_ms),
        ] {
            add(&self.steps.get_or_create(&[("step", step)]), milliseconds / 1e3);
        }
    }

    pub(super) fn panicked(&self) {
        self.panics.inc();
    }

    pub(super) fn text(&self, now: Gauges) -> String {
        let mut registry = Registry::with_prefix("grasp");
        let answers = self.answers.clone();
        registry.register("requests", "Requests that were answered, by path and status", answers);
        let seconds = self.seconds.clone();
        registry.register("request_seconds", "From a request's head to its answer, by path", seconds);
        registry.register("step_seconds", "How long the steps of a recognition took", self.steps.clone());
        let candidates = self.candidates.clone();
        registry.register("candidates", "Entries that a picture's search looked at", candidates);
        for (name, help, value) in [
            ("index_generation", "The index that is served, counted from 1", now.generation),
            ("index_entries", "Entries of the index that is served", now.entries),
            (
                "index_stale",
                "1 where the file at the index's path cannot be used, and an earlier one is served",
                now.index_is_stale.into(),
            ),
            ("requests_arriving", "Requests whose bodies are under way", now.arriving as u64),
            ("body_bytes_reserved", "Bytes that large bodies hold or will hold", now.reserved as u64),
            ("requests_inside", "Requests that are worked on or wait", now.inside as u64),
            ("ready", "1 where requests are answered", now.ready.into()),
        ] {
            registry.register(name, help, ConstGauge::new(value));
        }
        let failures = ConstCounter::new(now.reload_failures);
        registry.register("index_reload_failures", "New index files that could not be used", failures);
        registry.register("panics", "Requests that ended in a fault of the program", self.panics.clone());
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = encode(&mut text, &registry);
        text
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
        let text = metrics.text(Gauges { generation: 3, ready: true, ..Gauges::default() });
        for line in [
            "grasp_requests_total{path=\"/v1/search\",status=\"200\"} 2",
            "grasp_request_seconds_bucket{le=\"0.002\",path=\"/v1/search\"} 0",
            "grasp_request_seconds_bucket{le=\"0.005\",path=\"/v1/search\"} 1",
            "grasp_request_seconds_bucket{le=\"+Inf\",path=\"/v1/search\"} 2",
            "grasp_request_seconds_sum{path=\"/v1/search\"} 60.005",
            "grasp_request_seconds_count{path=\"other\"} 0",
            "grasp_step_seconds_bucket{le=\"0.00002\",step=\"search\"} 0",
            "grasp_step_seconds_bucket{le=\"0.00005\",step=\"search\"} 1",
            "grasp_candidates_bucket{le=\"200.0\"} 1",
            "grasp_candidates_count 1",
            "grasp_index_generation 3",
            "grasp_index_reload_failures_total 0",
            "grasp_panics_total 0",
            "grasp_ready 1",
        ] {
            assert!(text.lines().any(|found| found == line), "{line} is missing from\n{text}");
        }
        assert!(text.ends_with("# EOF\n"));
    }
}
