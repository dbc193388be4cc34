//! Arrays of descriptors on the disk, read and written a piece at a time.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write as _};
use std::ops::Range;
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;
use grasp_index::npy::{NpyError, NpyHeader, NpyType};
use xxhash_rust::xxh3::Xxh3;

/// Values that are read and held at a time.
const PIECE: u64 = 1 << 20;

/// An array of rows that is being read.
#[derive(Debug)]
pub(crate) struct Rows {
    header: NpyHeader,
    reader: BufReader<File>,
    done: u64,
    end: u64,
}

impl Rows {
    /// Opens an array of at least one row. What the file is too short for is told now, not after
    /// hours.
    pub(crate) fn open(path: &Path) -> anyhow::Result<Self> {
        let name = || format!("cannot use {}", path.display());
        let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        let metadata = file.metadata().with_context(name)?;
        if !metadata.is_file() {
            bail!("{} is not a regular file: name an array in .npy format", path.display());
        }
        let mut reader = BufReader::with_capacity(1 << 20, file);
        let header = NpyHeader::read(&mut reader, NpyType::F32).with_context(name)?;
        let expected = header.value_bytes().with_context(name)?;
        let found = metadata.len().saturating_sub(header.offset);
        if found < expected {
            return Err(NpyError::Truncated { expected, found }).with_context(name);
        }
        if header.rows == 0 || header.columns == 0 {
            bail!(
                "{} holds {} rows of {} values: it holds no value",
                path.display(),
                header.rows,
                header.columns
            );
        }
        Ok(Self { end: header.rows, header, reader, done: 0 })
    }

    /// How many rows there are.
    pub(crate) fn len(&self) -> u64 {
        self.header.rows
    }

    /// Values of a row.
    pub(crate) fn columns(&self) -> u64 {
        self.header.columns
    }

    /// Leaves only some of the rows, before any was read.
    pub(crate) fn narrow(&mut self, rows: Range<u64>) -> io::Result<()> {
        let (start, end) = (rows.start.min(self.header.rows), rows.end.min(self.header.rows));
        // The file is long enough for all of them, and so for these: nothing overflows.
        self.reader.seek_relative((start * self.header.columns * 4) as i64)?;
        self.done = start;
        self.end = end.max(start);
        Ok(())
    }

    /// The next rows; `None` after the last.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<f32>>, NpyError> {
        let rows = (PIECE / self.header.columns).max(1).min(self.end - self.done);
        if rows == 0 {
            return Ok(None);
        }
        let piece = NpyHeader { rows, ..self.header };
        let values = piece.read_values(&mut self.reader).map_err(|error| match error {
            NpyError::NotFinite { row, column, value } => {
                NpyError::NotFinite { row: row + self.done as usize, column, value }
            }
            other => other,
        })?;
        self.done += rows;
        Ok(Some(values))
    }

    /// The xxh3 of all values that are to come.
    pub(crate) fn digest(mut self) -> Result<u64, NpyError> {
        let mut hash = Xxh3::new();
        while let Some(values) = self.next()? {
            hash.update(bytemuck::cast_slice(&values));
        }
        Ok(hash.digest())
    }

    /// All rows at once.
    pub(crate) fn all(mut self) -> Result<Vec<f32>, NpyError> {
        self.header.read_values(&mut self.reader)
    }
}

/// Writes `rows` rows of `columns` values to `path`: all or nothing. `row` appends row after row,
/// and may stop the work.
pub(crate) fn write(
    path: &Path,
    rows: u64,
    columns: usize,
    mut row: impl FnMut(u64, &mut Vec<f32>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    let cannot = || format!("cannot write {}", path.display());
    let mut out = BufWriter::with_capacity(1 << 20, &mut file);
    let header = NpyHeader { element: NpyType::F32, rows, columns: columns as u64, offset: 0 };
    out.write_all(&header.to_bytes()).with_context(cannot)?;
    let mut values = Vec::with_capacity(columns);
    for at in 0..rows {
        values.clear();
        row(at, &mut values)?;
        out.write_all(bytemuck::cast_slice(&values)).with_context(cannot)?;
    }
    out.flush().with_context(cannot)?;
    drop(out);
    Ok(file.commit()?)
}
