//! The paper's Section VII over one's own labelled pictures: what it calls X (all), X' (the hand
//! near the object) and X'' (the hand grasping it), classed (its Figure 7) and oriented (its Figure
//! 8), with its own figures beside.

mod figures;
mod files;
mod plot;
mod published;
mod text;

use std::path::Path;

pub use figures::{Class, KindResult, Paper, SetResult};
pub use published::Published;

impl Paper {
    /// The table for a person.
    pub fn text(&self) -> String {
        text::text(self)
    }

    /// What [`Self::write`] writes.
    pub const FILES: [&str; 6] =
        ["paper.csv", "confusion.csv", "orientation.csv", "paper.json", "confusion.svg", "orientation.svg"];

    /// Writes [`Self::FILES`] into a folder, which is made where there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        files::write(self, folder)
    }
}
