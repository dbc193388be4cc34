//! Tables that say what pictures, renders and vectors show: the columns that they share, read by
//! name. Which of them are needed, and which values make sense, is for each kind of table to say.
//!
//! Columns come in any order; those that are not in [`Row`] are ignored. White space around a value
//! does not count.

mod line_ends;

use std::io::Read;

use csv::{Reader, ReaderBuilder, StringRecord};
use nalgebra::{Quaternion, UnitQuaternion};
use serde::Deserialize;

use line_ends::LineEnds;

/// How far a quaternion's length may be from 1: three decimals are enough.
const UNIT_TOLERANCE: f64 = 1e-2;

/// What begins a line that is a remark, in tables that have such lines.
pub const REMARK: u8 = b'#';

/// A table that is read line by line.
#[derive(Debug)]
pub struct Table<R> {
    reader: Reader<LineEnds<R>>,
    header: StringRecord,
    record: StringRecord,
    line: u64,
}

/// A line by its columns; `None` is a value that is empty, or whose column is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Row<'t> {
    /// The picture.
    pub file: Option<&'t str>,
    /// The hand's mask in the picture.
    pub mask: Option<&'t str>,
    /// Whether the picture is `segmented` or of a `camera`.
    pub kind: Option<&'t str>,
    /// The class.
    pub grasp: Option<&'t str>,
    /// The class's number in Cutkosky's taxonomy.
    pub cutkosky: Option<u8>,
    /// Whose hand it is.
    pub hand_shape: Option<&'t str>,
    /// How far the grasp is closed.
    pub stage: Option<&'t str>,
    /// Which hand it is.
    pub hand: Option<&'t str>,
    /// Degrees; finite, as the other angles are.
    pub azimuth: Option<f64>,
    /// Degrees.
    pub elevation: Option<f64>,
    /// Degrees.
    pub roll: Option<f64>,
    /// `camera_from_hand`, as are the next three: see [`Self::orientation`].
    pub qx: Option<f64>,
    /// The second imaginary part.
    pub qy: Option<f64>,
    /// The third imaginary part.
    pub qz: Option<f64>,
    /// The real part.
    pub qw: Option<f64>,
    /// What the hand holds.
    pub object: Option<&'t str>,
    /// Seed of what was drawn at random.
    pub seed: Option<u64>,
}

/// What is wrong with a line of a table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowFault {
    /// It cannot be read, or has more or fewer fields than the header.
    #[error("not a line of this table: {0}")]
    Csv(String),
    /// A field that should be a (finite) number, or is empty where one is needed.
    #[error("`{value}` in column `{column}` is not a number in the range of that column")]
    Number {
        /// The column.
        column: String,
        /// What stands there.
        value: String,
    },
    /// The four numbers are no rotation.
    #[error("qx, qy, qz, qw have length {0:.4}: camera_from_hand must be a unit quaternion")]
    NotUnit(f64),
}

impl<R: Read> Table<R> {
    /// A table whose header has been read; lines that begin with `remark` are passed over.
    ///
    /// # Errors
    /// Where the header, line 1, cannot be read.
    pub fn new(table: R, remark: Option<u8>) -> Result<Self, RowFault> {
        let mut reader = ReaderBuilder::new();
        // How many fields a line has is for [`Self::advance`] to say.
        reader.comment(remark).trim(csv::Trim::All).flexible(true);
        let mut reader = reader.from_reader(LineEnds::new(table));
        let header = reader.headers()?.clone();
        Ok(Self { reader, header, record: StringRecord::new(), line: 1 })
    }

    /// The names of the columns, in the table's order.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.header.iter()
    }

    /// Whether there is a column of that name.
    pub fn has(&self, column: &str) -> bool {
        self.columns().any(|name| name == column)
    }

    /// Goes on to the next line that is not empty; `false` behind the last one.
    ///
    /// # Errors
    /// Where the line cannot be read; the next one may be.
    pub fn advance(&mut self) -> Result<bool, RowFault> {
        loop {
            let read = self.reader.read_record(&mut self.record);
            let position = read.as_ref().map_or_else(csv::Error::position, |_| self.record.position());
            self.line = position.map_or(self.line, csv::Position::line);
            if !read? {
                return Ok(false);
            }
            // White space is as good as nothing, which the reader passes over by itself.
            let is_empty = self.record.len() == 1 && self.record[0].is_empty();
            match (self.record.len(), self.header.len()) {
                _ if is_empty => {}
                (found, expected) if found != expected => return Err(RowFault::fields(found, expected)),
                _ => return Ok(true),
            }
        }
    }

    /// The number of the line, counted from 1 with the header.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// All fields of the line, by the names of their columns.
    pub fn fields(&self) -> impl Iterator<Item = (&str, &str)> {
        self.columns().zip(&self.record)
    }

    /// The line.
    ///
    /// # Errors
    /// Where a value is no number that its column can hold.
    pub fn row(&self) -> Result<Row<'_>, RowFault> {
        let row: Row<'_> = self.record.deserialize(Some(&self.header)).map_err(|error| self.fault(&error))?;
        let angles = [("azimuth", row.azimuth), ("elevation", row.elevation), ("roll", row.roll)];
        for (column, value) in angles.into_iter().filter_map(|(column, value)| Some((column, value?))) {
            // An index keeps them as f32.
            if !(value as f32).is_finite() {
                return Err(RowFault::Number { column: column.into(), value: value.to_string() });
            }
        }
        Ok(row)
    }

    fn fault(&self, error: &csv::Error) -> RowFault {
        let csv::ErrorKind::Deserialize { err, .. } = error.kind() else {
            return RowFault::Csv(error.to_string());
        };
        let field = err.field().and_then(|field| self.fields().nth(field as usize));
        match field {
            Some((column, value)) => RowFault::Number { column: column.into(), value: value.into() },
            None => RowFault::Csv(err.kind().to_string()),
        }
    }
}

impl Row<'_> {
    /// The rotation from the hand's axes to the camera's; `None` where all four fields are empty.
    ///
    /// # Errors
    /// Where some of them are empty, or they are no unit quaternion.
    pub fn orientation(&self) -> Result<Option<UnitQuaternion<f64>>, RowFault> {
        let parts = [("qx", self.qx), ("qy", self.qy), ("qz", self.qz), ("qw", self.qw)];
        if parts.iter().all(|(_, part)| part.is_none()) {
            return Ok(None);
        }
        let needed = |(column, part): (&str, Option<f64>)| part.ok_or_else(|| RowFault::empty(column));
        let [x, y, z, w] = parts.map(needed);
        let rotation = Quaternion::new(w?, x?, y?, z?);
        let length = rotation.norm();
        if (length - 1.0).abs() <= UNIT_TOLERANCE {
            Ok(Some(UnitQuaternion::new_normalize(rotation)))
        } else {
            Err(RowFault::NotUnit(length))
        }
    }
}

impl RowFault {
    fn fields(found: usize, expected: usize) -> Self {
        let fields = if found == 1 { "field" } else { "fields" };
        Self::Csv(format!("it has {found} {fields} where the header has {expected}"))
    }

    /// A field without the number that is needed.
    pub fn empty(column: &str) -> Self {
        Self::Number { column: column.to_owned(), value: String::new() }
    }
}

impl From<csv::Error> for RowFault {
    fn from(error: csv::Error) -> Self {
        // Without the position, which messages have anyway.
        match error.into_kind() {
            csv::ErrorKind::Utf8 { .. } => Self::Csv("it is not UTF-8 text".into()),
            csv::ErrorKind::Io(error) => Self::Csv(error.to_string()),
            kind => Self::Csv(format!("{kind:?}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_columns_and_empty_ones_are_none() {
        let text = "\u{feff}note,qw,grasp,seed,qx,qy,qz\nx, 1.0 ,pinch,,0,0,0\n# a remark\n";
        let mut table = Table::new(text.as_bytes(), Some(REMARK)).unwrap();
        assert!(table.has("note") && table.advance().unwrap());
        let row = table.row().unwrap();
        assert_eq!((row.grasp, row.seed, row.file, table.line()), (Some("pinch"), None, None, 2));
        assert_eq!(row.orientation().unwrap(), Some(UnitQuaternion::identity()));
        assert_eq!(table.fields().next(), Some(("note", "x")));
        assert!(!table.advance().unwrap());
    }

    #[test]
    fn what_has_no_lines_is_no_table_and_ends() {
        let endless = Table::new(std::io::repeat(b'a'), None).unwrap_err().to_string();
        assert_eq!(endless, "not a line of this table: a line has more than 1 MiB: is it a table?");
        let text = format!("file\n{}\n", "a".repeat(3 << 20));
        let mut table = Table::new(text.as_bytes(), None).unwrap();
        assert!(table.advance().is_err());
        assert_eq!(table.advance(), Ok(false));
    }

    #[test]
    fn lines_of_white_space_are_no_rows_and_are_counted() {
        let mut table = Table::new("file,grasp\n\n  \t\na,pinch\n \r\n  ".as_bytes(), None).unwrap();
        assert!(table.advance().unwrap());
        assert_eq!((table.row().unwrap().file, table.line()), (Some("a"), 4));
        assert_eq!(table.advance(), Ok(false));
    }

    #[test]
    fn what_is_wrong_is_said_by_column_and_the_next_line_is_read() {
        let text = "cutkosky,roll,qz\n256,,\n9,inf,\n9\n9,,0\n9,,\n";
        let mut table = Table::new(text.as_bytes(), None).unwrap();
        let mut next = || table.advance().and_then(|_| table.row()?.orientation());
        let number = |what: &str| format!("{what} is not a number in the range of that column");
        assert_eq!(next().unwrap_err().to_string(), number("`256` in column `cutkosky`"));
        assert_eq!(next().unwrap_err().to_string(), number("`inf` in column `roll`"));
        let short = "not a line of this table: it has 1 field where the header has 3";
        assert_eq!(next().unwrap_err().to_string(), short);
        assert_eq!(next().unwrap_err().to_string(), number("`` in column `qw`"));
        assert_eq!(next(), Ok(None));
    }
}
