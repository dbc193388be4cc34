//! What more hand shapes in the index are worth: the paper's conclusion expects a gain from "a
//! training set with hands of many different shapes". The same labelled pictures are scored by
//! indexes of ever more of them.

mod figures;
mod plot;

use std::fs;
use std::path::Path;

use anyhow::Context as _;

use super::{csv_of, write_file};
pub use figures::{Point, Scored, Shapes};

impl Shapes {
    /// Writes `shapes.csv`, `shapes.json` and `shapes.svg` into a folder, which is made where there
    /// is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let mut json = serde_json::to_vec_pretty(self)?;
        json.push(b'\n');
        write_file(&folder.join("shapes.csv"), &csv_of(&self.points)?)?;
        write_file(&folder.join("shapes.json"), &json)?;
        write_file(&folder.join("shapes.svg"), plot::svg(self).as_bytes())
    }
}
