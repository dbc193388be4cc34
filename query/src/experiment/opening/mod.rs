//! What hands look like before they hold something: [`Opening`], fitted to labelled camera
//! pictures.

mod fit;

use std::fmt::Write as _;
use std::path::Path;

use grasp_index::{Index, NETWORK_STAGES, Reliability};
use grasp_recognise::scene::Opening;
use nalgebra::DVector;
use serde::Serialize;

use super::write_file;
use crate::evaluate::labels::Part;
use crate::evaluate::{Guess, Outcome};
use fit::{Example, fit};

/// The least probability that is taken seriously.
const LEAST: f64 = 1e-4;

/// One recognised picture.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The place of its table on the command line.
    table: usize,
    /// The place of its stage in [`NETWORK_STAGES`].
    stage: usize,
    part: Part,
    example: Example,
}

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Fitted {
    /// Fitted to seven tenths of the pictures of all tables.
    pub log_odds: Opening,
    /// What it is worth, a row for each table and stage.
    pub worth: Vec<Worth>,
}

/// What is gained on the pictures of one stage.
#[derive(Clone, Debug, Serialize)]
pub struct Worth {
    /// Their table.
    pub labels: String,
    /// Their stage.
    pub stage: &'static str,
    /// Which of them, and what it was fitted to.
    pub by: By,
    /// How many there are.
    pub n: usize,
    /// How many of them are classed rightly as they look, and with the opening.
    pub right: [usize; 2],
    /// The mean logarithm of the labelled class's probability, likewise.
    pub log_likelihood: [f64; 2],
    /// The calibration error of the first class's probability, likewise.
    pub ece: [Option<f64>; 2],
}

/// Which pictures are measured, and what was fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// The seven tenths that it was fitted to.
    Fitted,
    /// The rest.
    HeldOut,
    /// All of them, by what was fitted to the other tables alone.
    OtherTables,
}

impl Sample {
    /// What a picture of a table says of open hands, where it was recognised `by` this opening,
    /// which is taken off again; `None` where it was not recognised, or shows no stage or class that is known.
    pub fn new(table: usize, outcome: &Outcome, classes: &[String], by: &Opening) -> Option<Self> {
        let label = &outcome.label;
        let Guess { classes: found, stages, .. } = outcome.result.as_ref().ok()?;
        let [.., grasp] = (*stages)?;
        let open = 1.0 - grasp;
        let of = |name: &String| {
            let found = found.iter().find(|(found, _)| found == name);
            let probability = found.map_or(LEAST, |(_, probability)| probability.max(LEAST));
            // As it looks, without what the program knows of open hands already.
            libm::log(probability) - by.log_odds(name, open)
        };
        Some(Self {
            table,
            stage: NETWORK_STAGES.iter().position(|stage| *stage == label.stage)?,
            part: label.part(),
            example: Example {
                logs: DVector::from_iterator(classes.len(), classes.iter().map(of)),
                labelled: classes.iter().position(|name| *name == label.grasp)?,
                open,
            },
        })
    }
}

impl Fitted {
    /// Fits to the part of the samples to choose by, and measures on both parts and across tables.
    pub fn new(samples: &[Sample], tables: &[String], classes: &[String]) -> Self {
        let by = |is_meant: &dyn Fn(&Sample) -> bool| {
            let examples = samples.iter().filter(|sample| is_meant(sample)).map(|sample| &sample.example);
            fit(&examples.collect::<Vec<_>>(), classes.len())
        };
        let all = by(&|sample| sample.part == Part::Choose);
        let mut worth = Vec::new();
        for (table, labels) in tables.iter().enumerate() {
            let others = by(&|sample| sample.table != table);
            for (stage, &name) in NETWORK_STAGES.iter().enumerate() {
                let shown = |sample: &&Sample| sample.table == table && sample.stage == stage;
                let shown: Vec<&Sample> = samples.iter().filter(shown).collect();
                let part = |part: Part| shown.iter().filter(move |s| s.part == part).map(|s| &s.example);
                let of = |by, examples: Vec<&Example>, log_odds: &DVector<f64>| {
                    Worth::new((labels, name, by), &examples, log_odds)
                };
                worth.push(of(By::Fitted, part(Part::Choose).collect(), &all));
                worth.push(of(By::HeldOut, part(Part::Final).collect(), &all));
                if tables.len() > 1 {
                    let every = shown.iter().map(|sample| &sample.example).collect();
                    worth.push(of(By::OtherTables, every, &others));
                }
            }
        }
        worth.retain(|worth| worth.n > 0);
        let log_odds = classes.iter().cloned().zip(all.iter().map(|value| thousandths(*value))).collect();
        Self { log_odds: Opening { log_odds }, worth }
    }

    /// The figures for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for Worth { labels, stage, by, n, right, log_likelihood, ece } in &self.worth {
            let by = match by {
                By::Fitted => "fitted to",
                By::HeldOut => "held out",
                By::OtherTables => "by the others",
            };
            let share = right.map(|right| 100.0 * right as f64 / *n as f64);
            let ece = ece.map(|ece| ece.unwrap_or(0.0));
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{labels}, {stage:<5}, {by:<13} {n:5}: {:.1} -> {:.1} % right; mean logarithm {:.3} -> {:.3}; \
                 calibration error {:.3} -> {:.3}",
                share[0], share[1], log_likelihood[0], log_likelihood[1], ece[0], ece[1]
            );
        }
        text.push_str("\nlikelier while nothing is held, as a logarithm:\n");
        for (grasp, log_odds) in &self.log_odds.log_odds {
            let _ = writeln!(text, "  {grasp:<16} {log_odds:+.3}");
        }
        text
    }

    /// Writes it as `data/opening.toml` is written, with the command and the index that it was made
    /// by.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path, command: &str, index: &Index) -> anyhow::Result<()> {
        let (entries, hands) = (index.len(), index.catalogue().hand_shapes.len());
        let head = format!(
            "# Of a hand that does not hold its thing yet: how much likelier each grasp is than it looks, as a\n\
             # logarithm: see query/recognise/src/scene/opening.rs.\n\
             # Made by: {command}\n\
             # with an index of {entries} entries, {hands} hand shapes.\n\n"
        );
        write_file(path, (head + &toml::to_string(&self.log_odds)?).as_bytes())
    }
}

impl Worth {
    fn new(
        (labels, stage, by): (&str, &'static str, By),
        examples: &[&Example],
        fitted: &DVector<f64>,
    ) -> Self {
        let as_it_looks = DVector::zeros(fitted.len());
        let weighed = [&as_it_looks, fitted]
            .map(|log_odds| examples.iter().map(|e| (e.weighed(log_odds), e.labelled)).collect::<Vec<_>>());
        let answers = |weighed: &[(DVector<f64>, usize)]| -> Vec<(f64, bool)> {
            weighed.iter().map(|(all, labelled)| (all.max(), all.argmax().0 == *labelled)).collect()
        };
        Self {
            labels: labels.to_owned(),
            stage,
            by,
            n: examples.len(),
            right: weighed.each_ref().map(|w| answers(w).iter().filter(|(_, is_right)| *is_right).count()),
            log_likelihood: weighed.each_ref().map(|weighed| {
                let sum: f64 = weighed.iter().map(|(all, labelled)| libm::log(all[*labelled])).sum();
                sum / examples.len().max(1) as f64
            }),
            ece: weighed.each_ref().map(|w| Reliability::from_answers(answers(w)).expected_error()),
        }
    }
}

/// Rounded to what the pictures can say at most.
fn thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
