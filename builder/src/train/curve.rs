//! How a training went, as a table.

use std::fmt;
use std::path::Path;

use anyhow::Context as _;
use grasp_index::AtomicFile;
use grasp_terminal::text::{counted, percent};
use grasp_train::Losses;
use serde::{Deserialize, Serialize};

use super::Figures;

/// One validation. The columns are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Pictures that the network has been shown.
    pub samples: u64,
    /// The mean losses of the batches since the row before, as they are summed up.
    pub loss: f64,
    /// The class's.
    pub class_loss: f64,
    /// The stage's.
    pub stage_loss: f64,
    /// The rotation's.
    pub rotation_loss: f64,
    /// Other hands: the share of right classes, 0 to 1.
    pub hands_top1: f64,
    /// The median error of the rotation in degrees.
    pub hands_rotation_deg: f64,
    /// The share of right classes by the nearest neighbours.
    pub hands_neighbours_top1: f64,
    /// The same of other hands in the fifth of the recorded poses that can be held out.
    pub poses_top1: f64,
    /// The median error of the rotation in degrees.
    pub poses_rotation_deg: f64,
    /// The share of right classes by the nearest neighbours.
    pub poses_neighbours_top1: f64,
}

impl Row {
    pub(super) fn new(samples: u64, losses: &MeanLosses, [hands, poses]: [Figures; 2]) -> Self {
        let [class, stage, rotation, total] = losses.mean();
        Self {
            samples,
            loss: rounded(total),
            class_loss: rounded(class),
            stage_loss: rounded(stage),
            rotation_loss: rounded(rotation),
            hands_top1: rounded(hands.top1),
            hands_rotation_deg: rounded(hands.rotation_deg),
            hands_neighbours_top1: rounded(hands.neighbours_top1),
            poses_top1: rounded(poses.top1),
            poses_rotation_deg: rounded(poses.rotation_deg),
            poses_neighbours_top1: rounded(poses.neighbours_top1),
        }
    }
}

/// Four decimals: more mean nothing.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

impl fmt::Display for Row {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = counted(self.samples, ["sample", "samples"]);
        write!(formatter, "{samples}: loss {:.3}", self.loss)?;
        let groups = [
            ("other hands", self.hands_top1, self.hands_rotation_deg, self.hands_neighbours_top1),
            // Held out or trained on, as the training was asked to.
            ("recorded poses", self.poses_top1, self.poses_rotation_deg, self.poses_neighbours_top1),
        ];
        for (group, top1, rotation, neighbours) in groups {
            let [top1, neighbours] = [top1, neighbours].map(percent);
            write!(formatter, "; {group} {top1}, {rotation:.1} deg, by neighbours {neighbours}")?;
        }
        Ok(())
    }
}

/// The losses of the steps since the last row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MeanLosses {
    /// Class, stage, rotation, total.
    sums: [f64; 4],
    steps: u64,
}

impl MeanLosses {
    pub(super) fn add(&mut self, losses: &Losses) {
        let values = [losses.class, losses.stage, losses.rotation, losses.total()];
        self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
        self.steps += 1;
    }

    fn mean(&self) -> [f64; 4] {
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
    for row in rows {
        table.serialize(row).with_context(failed)?;
    }
    Ok(table.into_inner().map_err(|error| error.into_error()).with_context(failed)?.commit()?)
}
