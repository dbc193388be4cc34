//! How far a robot's grasp may be off: the paper's Section VI, by trials on a grid of positions and
//! over a range of yaws.

mod plot;
mod sweep;
mod table;

use std::path::Path;

use super::{csv_of, write_file};
pub use sweep::{Cell, ENGINE, Progress, Robustness, Sweep, Tolerance};
pub use table::Row;

impl Robustness {
    /// Writes `windows.csv` and `robustness.svg` beside the table.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        write_file(&folder.join("windows.csv"), &csv_of(&self.tolerances)?)?;
        write_file(&folder.join("robustness.svg"), plot::svg(self).as_bytes())
    }
}
