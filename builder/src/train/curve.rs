//! How a training went, as a table.

use std::fmt;
use std::path::Path;

use anyhow::Context as _;
use grasp_index::AtomicFile;
use grasp_terminal::text::counted;
use grasp_train::{Factors, Losses};
use serde::{Deserialize, Serialize};

use super::figures::Figure;

/// One validation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Pictures that the network has been shown.
    pub samples: u64,
    /// The mean losses of the batches since the row before, `loss` as they are summed up.
    pub losses: Vec<Figure>,
    /// How well the network does.
    pub figures: Vec<Figure>,
}

impl Row {
    pub(super) fn new(samples: u64, losses: &MeanLosses, has_masks: bool, figures: Vec<Figure>) -> Self {
        let names = ["loss", "class_loss", "stage_loss", "rotation_loss", "joint_loss", "mask_loss"];
        let count = if has_masks { names.len() } else { names.len() - 1 };
        let losses =
            names.iter().zip(losses.mean()).take(count).map(|(name, value)| Figure::new(name, value));
        Self { samples, losses: losses.collect(), figures }
    }

    /// The columns' names: an interface, which may be added to and is never renamed.
    fn names(&self) -> impl Iterator<Item = &str> {
        let figures = self.losses.iter().chain(&self.figures);
        std::iter::once("samples").chain(figures.map(|figure| figure.name.as_str()))
    }

    fn values(&self) -> impl Iterator<Item = String> {
        let figures = self.losses.iter().chain(&self.figures);
        std::iter::once(self.samples.to_string()).chain(figures.map(|figure| figure.value.to_string()))
    }
}

impl fmt::Display for Row {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = counted(self.samples, ["sample", "samples"]);
        write!(formatter, "{samples}")?;
        for loss in self.losses.iter().take(1) {
            write!(formatter, ": loss {:.3}", loss.value)?;
        }
        self.figures.iter().try_for_each(|figure| write!(formatter, "; {figure}"))
    }
}

/// The losses of the steps since the last row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MeanLosses {
    /// Total, class, stage, rotation, joints, masks.
    sums: [f64; 6],
    steps: u64,
}

impl MeanLosses {
    pub(super) fn add(&mut self, losses: &Losses, factors: &Factors) {
        let total = losses.total(factors);
        let values = [total, losses.class, losses.stage, losses.rotation, losses.joints, losses.masks];
        self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
        self.steps += 1;
    }

    fn mean(&self) -> [f64; 6] {
        self.sums.map(|sum| sum / self.steps.max(1) as f64)
    }
}

/// Writes a curve, whole or not at all.
///
/// # Errors
/// Where the file cannot be written.
pub(super) fn write(path: &Path, rows: &[Row]) -> anyhow::Result<()> {
    let failed = || format!("cannot write {}", path.display());
    let mut table = csv::Writer::from_writer(AtomicFile::create(path)?);
    if let Some(first) = rows.first() {
        table.write_record(first.names()).with_context(failed)?;
    }
    for row in rows {
        table.write_record(row.values()).with_context(failed)?;
    }
    Ok(table.into_inner().map_err(|error| error.into_error()).with_context(failed)?.commit()?)
}
