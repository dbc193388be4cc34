//! The results as a table that stopped work goes on from.

use std::path::Path;

use anyhow::Context as _;
use grasp_index::AtomicFile;
use serde::{Deserialize, Serialize};

/// One index, measured. The columns are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// `random` or `learned`.
    pub hash: String,
    /// How many entries were asked for.
    pub size: u64,
    /// How many the index holds: the nearest that whole hand shapes come to `size`.
    pub entries: u64,
    /// Seconds to build it, descriptors at hand.
    pub build_s: f64,
    /// Threads that built it.
    pub threads: usize,
    /// Its length.
    pub file_bytes: u64,
    /// Nanoseconds a query, on one thread: the median of some rounds over all queries.
    pub ns_per_query: f64,
    /// Entries that a query looks at, on average.
    pub candidates: f64,
    /// The same as a share of the index, 0..=1.
    pub share_of_database: f64,
    /// The share of the true 10 nearest that is found.
    pub recall_at_10: f64,
    /// The share of queries whose nearest found is within 1.05 of the true nearest.
    pub eps_success: f64,
    /// The recall that the index promises for the effort.
    pub predicted_recall: Option<f64>,
    /// What was indexed and searched for.
    pub data: String,
}

/// Reads a table; a missing file is an empty one.
///
/// # Errors
/// Where the file cannot be read or is no such table.
pub fn read(path: &Path) -> anyhow::Result<Vec<Row>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let rows = csv::Reader::from_path(path).and_then(|mut table| table.deserialize().collect());
    rows.with_context(|| {
        format!("{} is not a table of this experiment: name another folder with --out", path.display())
    })
}

/// Writes a table, whole or not at all.
///
/// # Errors
/// Where the file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> anyhow::Result<()> {
    let failed = || format!("cannot write {}", path.display());
    let mut table = csv::Writer::from_writer(AtomicFile::create(path)?);
    for row in rows {
        table.serialize(row).with_context(failed)?;
    }
    Ok(table.into_inner().map_err(|error| error.into_error()).with_context(failed)?.commit()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scale.csv");
        assert_eq!(read(&path).unwrap(), []);
        let rows = [
            Row { hash: "random".into(), size: 5012, candidates: 0.1, ..Row::default() },
            Row { predicted_recall: Some(0.97), data: "a, b".into(), ..Row::default() },
        ];
        write(&path, &rows).unwrap();
        assert_eq!(read(&path).unwrap(), rows);
        std::fs::write(&path, "file,grasp\na.png,pinch\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("is not a table of this experiment"));
    }
}
