//! How hard to look for neighbours: the options that all searching subcommands share.

use std::ops::RangeBounds as _;

use grasp_index::{Effort, SearchOptions};
use grasp_recognise::ranges;

/// The options' heading. Named for each of them: that of a struct would go on behind its last
/// option.
const HEADING: &str = "How hard to search";

/// A wanted success, which the index looks up in what it has measured, or the effort itself.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct EffortArguments {
    /// Find this share of the true 10 nearest, on average, as measured when the index was built
    /// [default: 0.95].
    #[arg(long, help_heading = HEADING, value_name = "SHARE", allow_negative_numbers = true, value_parser = parse_share, conflicts_with_all = ["eps", "probes", "exact"])]
    recall: Option<f64>,
    /// Find a neighbour at most 1 + E times as far as the true nearest, e.g. 0.05, with --success
    /// of the queries.
    #[arg(long, help_heading = HEADING, value_name = "E", allow_negative_numbers = true, value_parser = parse_eps, conflicts_with_all = ["probes", "exact"])]
    eps: Option<f64>,
    /// The share of queries that must reach --eps; without it, 0.95.
    #[arg(long, help_heading = HEADING, value_name = "SHARE", allow_negative_numbers = true, value_parser = parse_share, requires = "eps")]
    success: Option<f64>,
    /// Look into N buckets of each table, whatever that finds.
    #[arg(long, help_heading = HEADING, value_name = "N", value_parser = clap::value_parser!(u32).range(i64::from(*ranges::PROBES.start())..), conflicts_with = "exact")]
    probes: Option<u32>,
    /// Compare with every entry of the index instead of searching its tables.
    #[arg(long, help_heading = HEADING)]
    exact: bool,
}

impl EffortArguments {
    pub(super) fn effort(&self) -> Effort {
        if self.exact {
            return Effort::Exact;
        }
        match *self {
            Self { probes: Some(probes), .. } => Effort::Probes(probes),
            Self { eps: Some(eps), success, .. } => {
                Effort::Success { eps, success: success.unwrap_or(Effort::DEFAULT_SUCCESS) }
            }
            Self { recall: Some(recall), .. } => Effort::Recall(recall),
            _ => SearchOptions::default().effort,
        }
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| ranges::RECALL.contains(share));
    share.ok_or_else(|| "a number above 0 and at most 1 is needed, such as 0.95".into())
}

fn parse_eps(text: &str) -> Result<f64, String> {
    let eps = text.parse().ok().filter(|eps| ranges::EPS.contains(eps));
    eps.ok_or_else(|| "a number of 0 or more is needed, such as 0.05".into())
}
