//! How well hands in one of the grasps are told from all else: pictures of no grasp, open hands,
//! things that are no hand.

mod figures;
mod plot;

use std::path::Path;

use serde::Serialize;

use super::{csv_of, json_of, write_files};
pub use figures::{AtLimits, Curve, Limits, Point, Unknown};

/// A row of `unknown.csv`. Columns are an interface, like keys.
#[derive(Serialize)]
struct Row {
    measure: &'static str,
    limit: f64,
    known_kept: f64,
    others_kept: f64,
}

impl Unknown {
    /// What [`Self::write`] writes.
    pub const FILES: [&str; 3] = ["unknown.csv", "unknown.json", "unknown.svg"];

    /// Writes [`Self::FILES`] into a folder, which is made where there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let rows = self.curves.iter().flat_map(|curve| {
            curve.points.iter().map(|&Point { limit, known_kept, others_kept }| Row {
                measure: curve.measure,
                limit,
                known_kept,
                others_kept,
            })
        });
        write_files(folder, Self::FILES, [csv_of(rows)?, json_of(self)?, plot::svg(self).into_bytes()])
    }
}
