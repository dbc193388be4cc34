//! What more hand shapes in the index are worth: the paper's conclusion expects a gain from "a
//! training set with hands of many different shapes". The same labelled pictures are scored by
//! indexes of ever more of them.

mod figures;
mod plot;

use std::path::Path;

use super::{csv_of, json_of, write_files};
pub use figures::{Point, Scored, Shapes};

impl Shapes {
    /// What [`Self::write`] writes.
    pub const FILES: [&str; 3] = ["shapes.csv", "shapes.json", "shapes.svg"];

    /// Writes [`Self::FILES`] into a folder, which is made where there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let drawing = plot::svg(self).into_bytes();
        write_files(folder, Self::FILES, [csv_of(&self.points)?, json_of(self)?, drawing])
    }
}
