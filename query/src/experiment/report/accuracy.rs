//! How many pictures were classed rightly, in all and group by group.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::evaluate::confusion::Share;
use crate::evaluate::report::Report;

/// The accuracy over a group of pictures.
#[derive(Clone, Debug, Serialize)]
pub struct Accuracy {
    /// What groups them: `all`, `class`, `stage`, `kind`, `group` or `hand`.
    pub by: &'static str,
    /// Which of these groups it is.
    pub name: String,
    /// How many there are, and how many of them are right.
    #[serde(flatten)]
    pub share: Share,
    /// Between which shares the true one lies, 0..=1, with 95 % confidence (Wilson).
    pub interval: [f64; 2],
}

impl Accuracy {
    fn new(by: &'static str, name: &str, share: Share) -> Self {
        Self { by, name: name.to_owned(), share, interval: share.interval() }
    }

    /// Of all pictures first, then by every column that groups them.
    pub(super) fn all(report: &Report) -> Vec<Self> {
        let groups: [(&str, &BTreeMap<String, Share>); 5] = [
            ("class", &report.per_class),
            ("stage", &report.per_stage),
            ("kind", &report.per_kind),
            ("group", &report.per_group),
            ("hand", &report.per_hand),
        ];
        let all = Self::new("all", "all pictures", report.confusion.share());
        let grouped = groups
            .into_iter()
            .flat_map(|(by, shares)| shares.iter().map(move |(name, share)| Self::new(by, name, *share)));
        std::iter::once(all).chain(grouped).collect()
    }
}
