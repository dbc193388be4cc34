//! The figures of the page.

use grasp_terminal::text::counted;
use serde::Serialize;

use super::accuracy::Accuracy;
use super::shelf::{self, Shelves};
use crate::evaluate::Outcome;
use crate::evaluate::confusion::Share;
use crate::evaluate::labels::{OTHER, RowError};
use crate::evaluate::report::{Report, errors_text};

/// The figures of the page. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Findings {
    /// The table of labels.
    pub labels: String,
    /// The index.
    pub index: String,
    /// What `evaluate` says of the same pictures.
    #[serde(flatten)]
    pub report: Report,
    /// The share of rightly classed pictures, overall and group by group.
    pub accuracy: Vec<Accuracy>,
    /// How long pictures took.
    pub speed: Speed,
    /// Every error of a rotation, in degrees, ascending.
    pub orientation_errors_deg: Vec<f64>,
    /// The same over rightly classed pictures alone.
    pub orientation_errors_deg_right_class: Vec<f64>,
    /// The pictures that are shown.
    pub shown: Shelves,
}

/// Times of one picture, decoding included, in milliseconds, while as many were worked on at once
/// as there were threads. 0 where there are no pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// Half of them took at most this.
    pub p50_ms: f64,
    /// 99 of 100 took at most this.
    pub p99_ms: f64,
    /// The slowest.
    pub most_ms: f64,
    /// How many were worked on at once.
    pub threads: usize,
}

/// Whose pictures were recognised by what.
#[derive(Clone, Debug)]
pub struct Source {
    /// The table of labels, as it was named.
    pub labels: String,
    /// The index, as it was named.
    pub index: String,
    /// The index's classes.
    pub classes: Vec<String>,
    /// Whether left or right was left to the program.
    pub hand_is_free: bool,
}

impl Findings {
    /// Sums up outcomes and the rows that could not be read; of each kind of answer `show` pictures
    /// are shown.
    pub fn new(source: Source, outcomes: &[Outcome], broken: &[RowError], show: usize) -> Self {
        let Source { labels, index, classes, hand_is_free } = source;
        let report = Report::new(classes, outcomes, broken, hand_is_free);
        let errors = |is_meant: &dyn Fn(&Outcome) -> bool| {
            let scored = outcomes.iter().filter(|outcome| outcome.label.grasp != OTHER);
            let meant = scored.filter(|outcome| is_meant(outcome));
            let mut errors: Vec<f64> = meant.filter_map(Outcome::orientation_error_deg).collect();
            errors.sort_by(f64::total_cmp);
            errors
        };
        let usable = outcomes.iter().filter(|outcome| shelf::is_usable(outcome));
        Self {
            labels,
            index,
            accuracy: Accuracy::all(&report),
            speed: Speed::of(usable.map(|outcome| outcome.ms).collect()),
            orientation_errors_deg: errors(&|_| true),
            orientation_errors_deg_right_class: errors(&Outcome::is_right),
            shown: Shelves::new(outcomes, show),
            report,
        }
    }

    /// The figures for a person, in a few lines.
    pub fn text(&self) -> String {
        let Report { n, unknown, errors, .. } = &self.report;
        let mut text = String::new();
        if let Some(all) = self.accuracy.first() {
            let [low, high] = all.interval.map(|bound| 100.0 * bound);
            text += &format!(
                "top-1 {:.1} % of {} ({low:.0} to {high:.0} % with 95 % confidence), {unknown} unknown or without a hand\n",
                100.0 * all.share.top1(),
                counted(*n, ["picture", "pictures"]),
            );
        }
        let Speed { p50_ms, p99_ms, threads, .. } = self.speed;
        let at_once = counted(threads, ["thread", "threads"]);
        text += &format!("a picture takes {p50_ms:.1} ms (p50), {p99_ms:.1} ms (p99), on {at_once}\n");
        text + &errors_text(errors)
    }
}

impl Speed {
    fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        // The least time that so many of a hundred do not exceed.
        let within = |percent: usize| {
            let rank = (times.len() * percent).div_ceil(100);
            times.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
        };
        let threads = rayon::current_num_threads();
        Self { p50_ms: within(50), p99_ms: within(99), most_ms: within(100), threads }
    }
}

/// A share as people read it, and between which it lies with 95 % confidence.
pub(super) fn percents(share: Share) -> (String, String) {
    let [low, high] = share.interval().map(|bound| 100.0 * bound);
    (format!("{:.1} %", 100.0 * share.top1()), format!("{low:.0} to {high:.0} %"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_times_that_were_measured() {
        let speed = Speed::of((1..=200).rev().map(f64::from).collect());
        assert_eq!((speed.p50_ms, speed.p99_ms, speed.most_ms), (100.0, 198.0, 200.0));
        let one = Speed::of(vec![7.0]);
        assert_eq!((one.p50_ms, one.p99_ms), (7.0, 7.0));
        assert_eq!(Speed::of(Vec::new()).p99_ms, 0.0);
    }

    #[test]
    fn shares_are_written_with_their_intervals() {
        assert_eq!(percents(Share { n: 12, right: 9 }), ("75.0 %".into(), "47 to 91 %".into()));
    }
}
