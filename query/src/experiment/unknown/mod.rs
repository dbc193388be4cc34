//! How well hands in one of the grasps are told from all else: pictures of no grasp, open hands,
//! things that are no hand.

mod figures;
mod plot;

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use serde::Serialize;

use super::{csv_of, write_file};
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
    /// Writes `unknown.csv`, `unknown.json` and `unknown.svg` into a folder, which is made where
    /// there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let mut json = serde_json::to_vec_pretty(self)?;
        json.push(b'\n');
        let rows = self.curves.iter().flat_map(|curve| {
            curve.points.iter().map(|&Point { limit, known_kept, others_kept }| Row {
                measure: curve.measure,
                limit,
                known_kept,
                others_kept,
            })
        });
        write_file(&folder.join("unknown.csv"), &csv_of(rows)?)?;
        write_file(&folder.join("unknown.json"), &json)?;
        write_file(&folder.join("unknown.svg"), plot::svg(self).as_bytes())
    }
}
