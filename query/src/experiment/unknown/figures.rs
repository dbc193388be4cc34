//! The figures, summed up from outcomes.

use std::fmt::Write as _;

use grasp_terminal::text::counted;
use serde::Serialize;

use crate::evaluate::labels::{OTHER, RowError};
use crate::evaluate::report::{Report, RowReport, errors_text};
use crate::evaluate::{Guess, Outcome};
use grasp_index::Calibration;
use grasp_recognise::Accept;

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Unknown {
    /// The table of labels.
    pub labels: String,
    /// Pictures of the index's grasps in which a hand was found.
    pub known: usize,
    /// Of these, how many were classed rightly, known or not.
    pub right: usize,
    /// Pictures of something else in which a hand was found.
    pub others: usize,
    /// Pictures of something else in which none was found: they are told already.
    pub no_hand: usize,
    /// What the program makes of them by its limits; null where it has none.
    pub at_limits: Option<AtLimits>,
    /// The curves, one for each measure.
    pub curves: Vec<Curve>,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

/// Beyond which a hand is unknown.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The farthest distance of the nearest entry.
    pub farthest: f64,
    /// The least probability, as the neighbours say it.
    pub least_probability: f64,
    /// The least trust in a hand that was found in a camera picture.
    pub least_trust: f64,
}

impl Limits {
    /// Those that `accept` sets, by the index's calibration and the model of trust; `None` where it
    /// sets none, or the index has none.
    pub fn new(accept: Accept, calibration: &Calibration, least_trust: f64) -> Option<Self> {
        let least_probability = calibration.least_probability;
        match accept {
            Accept::Always => None,
            Accept::Within(farthest) => Some(Self { farthest, least_probability: 0.0, least_trust: 0.0 }),
            Accept::Calibrated => {
                calibration.farthest.map(|farthest| Self { farthest, least_probability, least_trust })
            }
        }
    }
}

/// The shares that become unknown, 0..=1 each: beyond the limits, or rather in none of the grasps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtLimits {
    /// The farthest distance of the nearest entry.
    pub farthest: f64,
    /// The least probability, as the neighbours say it.
    pub least_probability: f64,
    /// The least trust in a hand that was found in a camera picture.
    pub least_trust: f64,
    /// The share of known hands that become unknown.
    pub known_lost: f64,
    /// The same of those that are classed rightly.
    pub right_lost: f64,
    /// The share of others that become unknown.
    pub others_told: f64,
}

/// What a measure tells, at every limit.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// `nearest`, `probability` (as neighbours and networks say it), `trust`, or `stated` (the
    /// probability that an answer states, tempered by trust).
    pub measure: &'static str,
    /// The area under the curve: 0.5 tells nothing, 1 tells all. Null without known hands or
    /// others.
    pub area: Option<f64>,
    /// From the strictest limit to the most lenient.
    pub points: Vec<Point>,
}

/// A limit, and who keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The limit on the measure.
    pub limit: f64,
    /// The share of known hands within it, 0..=1.
    pub known_kept: f64,
    /// The share of others within it, 0..=1.
    pub others_kept: f64,
}

impl Unknown {
    /// Sums up outcomes, of which those labelled [`OTHER`] are of no class, and the rows that could
    /// not be read. `outcomes` are before any limit and before trust tempers a probability;
    /// `stated` are those of the same pictures, in the same order, as the program states them, by
    /// these limits, where it has any.
    pub fn new(
        labels: String,
        outcomes: &[Outcome],
        broken: &[RowError],
        stated: &[Outcome],
        limits: Option<Limits>,
    ) -> Self {
        let errors = Report::new(Vec::new(), outcomes, broken, false).errors;
        let (others, known): (Vec<&Outcome>, Vec<&Outcome>) =
            outcomes.iter().partition(|outcome| outcome.label.grasp == OTHER);
        let no_hand =
            others.iter().filter(|o| o.result.as_ref().is_err_and(|miss| miss.is_rejection)).count();
        let right = known.iter().filter(|outcome| outcome.is_right()).count();
        let curve = |measure, of: &[Outcome], value: &dyn Fn(&Guess) -> f64, sign: f64| {
            let values = |is_other| {
                let group = of.iter().filter(|outcome| (outcome.label.grasp == OTHER) == is_other);
                group.filter_map(|one| one.result.as_ref().ok()).map(|guess| sign * value(guess)).collect()
            };
            Curve::new(measure, values(false), values(true), sign)
        };
        let curves = vec![
            curve("nearest", outcomes, &|guess| guess.nearest, 1.0),
            curve("probability", outcomes, &|guess| guess.probability, -1.0),
            curve("trust", outcomes, &|guess| guess.trust.unwrap_or(1.0), -1.0),
            curve("stated", stated, &|guess| guess.probability, -1.0),
        ];
        let [known, others] = [known, others].map(|all| all.iter().filter(|one| one.result.is_ok()).count());
        let at_limits = limits.map(|Limits { farthest, least_probability, least_trust }| {
            let lost = |of: &dyn Fn(&Outcome) -> bool| {
                let found = outcomes.iter().zip(stated).filter(|(one, _)| one.result.is_ok() && of(one));
                let lost: Vec<bool> = found.map(|(_, stated)| stated.is_unknown()).collect();
                lost.iter().filter(|is_lost| **is_lost).count() as f64 / lost.len().max(1) as f64
            };
            let is_other = |outcome: &Outcome| outcome.label.grasp == OTHER;
            AtLimits {
                farthest,
                least_probability,
                least_trust,
                known_lost: lost(&|one| !is_other(one)),
                right_lost: lost(&|one| one.is_right()),
                others_told: lost(&is_other),
            }
        });
        Self { labels, known, right, others, no_hand, at_limits, curves, errors }
    }

    /// The figures for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write_text(&mut text);
        text
    }

    fn write_text(&self, text: &mut String) -> std::fmt::Result {
        let Self { known, right, others, no_hand, .. } = self;
        writeln!(
            text,
            "{} ({right} classified correctly), {}; in {no_hand} more of the others no hand was found",
            counted(*known, ["known hand", "known hands"]),
            counted(*others, ["other", "others"])
        )?;
        for Curve { measure, area, .. } in &self.curves {
            let area = area.map_or_else(|| "-".to_owned(), |area| format!("{area:.3}"));
            writeln!(text, "{measure:<12} area under the curve {area}")?;
        }
        if let Some(at) = &self.at_limits {
            writeln!(
                text,
                "unknown to the program (farther than {:.3}, less probable than {:.2}, less trusted than {:.2}, or rather in none of the grasps): {:.1} % of the others, {:.1} % of the known, {:.1} % of those classified correctly",
                at.farthest,
                at.least_probability,
                at.least_trust,
                100.0 * at.others_told,
                100.0 * at.known_lost,
                100.0 * at.right_lost
            )?;
        }
        text.push_str(&errors_text(&self.errors));
        Ok(())
    }
}

impl Curve {
    /// Of values of which small ones speak for a known hand; `sign` makes limits of them.
    pub(super) fn new(measure: &'static str, mut known: Vec<f64>, mut others: Vec<f64>, sign: f64) -> Self {
        known.sort_by(f64::total_cmp);
        others.sort_by(f64::total_cmp);
        let mut limits: Vec<f64> = known.iter().chain(&others).copied().collect();
        limits.sort_by(f64::total_cmp);
        limits.dedup();
        let kept = |values: &[f64], limit: f64| {
            values.partition_point(|value| *value <= limit) as f64 / values.len().max(1) as f64
        };
        let points = limits.iter().map(|&limit| Point {
            limit: sign * limit,
            known_kept: kept(&known, limit),
            others_kept: kept(&others, limit),
        });
        // Of all pairs, how often the known hand speaks more for itself; equals count a half.
        let wins: f64 = known
            .iter()
            .map(|value| {
                let [less, no_more] = [
                    others.partition_point(|other| other < value),
                    others.partition_point(|other| other <= value),
                ];
                (others.len() - no_more) as f64 + (no_more - less) as f64 / 2.0
            })
            .sum();
        let pairs = known.len() as f64 * others.len() as f64;
        Self { measure, area: (pairs > 0.0).then(|| wins / pairs), points: points.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_by_hand() {
        let area =
            |known: &[f64], others: &[f64]| Curve::new("nearest", known.into(), others.into(), 1.0).area;
        assert_eq!(area(&[0.1, 0.2], &[0.3, 0.4]), Some(1.0));
        assert_eq!(area(&[0.1, 0.3], &[0.2, 0.3]), Some(2.5 / 4.0));
        assert_eq!(area(&[0.1], &[]), None);
        let curve = Curve::new("probability", vec![-0.9, -0.5], vec![-0.5], -1.0);
        assert_eq!(curve.points[0], Point { limit: 0.9, known_kept: 0.5, others_kept: 0.0 });
        assert_eq!(curve.points[1], Point { limit: 0.5, known_kept: 1.0, others_kept: 1.0 });
    }
}
