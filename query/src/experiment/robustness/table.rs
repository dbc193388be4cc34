//! The table of trials, which grows while they run and can be gone on with.

use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context as _, bail};
use serde::{Deserialize, Serialize};

use crate::experiment::{csv_of, write_file};

/// A line of `robustness.csv`. Columns are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The object.
    pub object: String,
    /// The robot's grasp.
    pub grasp: String,
    /// The object's displacement, in millimetres.
    pub x_mm: i32,
    /// The same.
    pub y_mm: i32,
    /// The hand's turn, in degrees.
    pub yaw_deg: i32,
    /// Whether it was lifted and held.
    pub success: bool,
    /// Whether it was lifted.
    pub lifted: bool,
    /// Millimetres.
    pub rise_mm: f64,
    /// Millimetres.
    pub slip_mm: f64,
    /// Newtons.
    pub contact_force_n: f64,
    /// What the row was made with: the hand and the engine. Another's rows are not taken over.
    pub made_with: String,
}

impl Row {
    /// Which trial it is.
    pub(super) fn key(&self) -> (&str, i32, i32, i32) {
        (&self.object, self.x_mm, self.y_mm, self.yaw_deg)
    }
}

/// Rows, and where they are written to.
#[derive(Debug)]
pub(super) struct Table {
    known: Vec<Row>,
    path: Option<PathBuf>,
    growing: Mutex<Growing>,
}

#[derive(Debug)]
struct Growing {
    rows: Vec<Row>,
    file: Option<File>,
}

impl Table {
    /// Reads what a folder's table holds; a line that was cut short is left out. Without a folder
    /// nothing is kept.
    pub(super) fn open(folder: Option<&Path>, made_with: String) -> anyhow::Result<Self> {
        let Some(folder) = folder else {
            return Ok(Self {
                known: Vec::new(),
                path: None,
                growing: Growing { rows: Vec::new(), file: None }.into(),
            });
        };
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join("robustness.csv");
        let known = read(&path)?;
        if let Some(row) = known.iter().find(|row| row.made_with != made_with) {
            bail!(
                "{} was made with another hand or engine ({}): name another folder, or remove it",
                path.display(),
                row.made_with
            );
        }
        // Whole lines only, before more are appended.
        write_file(&path, &csv_of(&known)?)?;
        let file = OpenOptions::new().append(true).open(&path);
        let file = file.with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { known, path: Some(path), growing: Growing { rows: Vec::new(), file: Some(file) }.into() })
    }

    /// Whether a trial of this key is known.
    pub(super) fn holds(&self, key: (&str, i32, i32, i32)) -> bool {
        self.known.iter().any(|row| row.key() == key)
    }

    /// Adds a trial, on the disk at once.
    pub(super) fn append(&self, row: Row) -> anyhow::Result<()> {
        // A thread that panicked while it held the lock left whole rows behind.
        let mut growing = self.growing.lock().unwrap_or_else(PoisonError::into_inner);
        let is_first = self.known.is_empty() && growing.rows.is_empty();
        if let (Some(file), Some(path)) = (&mut growing.file, &self.path) {
            let mut writer = csv::WriterBuilder::new().has_headers(is_first).from_writer(Vec::new());
            writer.serialize(&row)?;
            let written = file.write_all(&writer.into_inner().map_err(|error| error.into_error())?);
            written.with_context(|| format!("cannot write {}", path.display()))?;
        }
        growing.rows.push(row);
        Ok(())
    }

    /// All rows in order; the table on the disk is put in order too, so that its bytes do not tell
    /// which thread was faster.
    pub(super) fn finish(self) -> anyhow::Result<Vec<Row>> {
        let mut rows = self.known;
        rows.extend(self.growing.into_inner().unwrap_or_else(PoisonError::into_inner).rows);
        rows.sort_by(|a, b| a.key().cmp(&b.key()));
        if let Some(path) = self.path {
            write_file(&path, &csv_of(&rows)?)?;
        }
        Ok(rows)
    }
}

fn read(path: &Path) -> anyhow::Result<Vec<Row>> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    // What follows the last line's end was being written when the work was stopped.
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let lines = bytes.get(..whole).unwrap_or_default();
    let rows = csv::Reader::from_reader(lines).into_deserialize().collect::<Result<_, _>>();
    rows.with_context(|| {
        format!("{} is not a table of trials: name another folder, or remove it", path.display())
    })
}
