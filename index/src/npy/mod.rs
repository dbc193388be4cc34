//! Arrays of numbers in NumPy's `.npy` format, versions 1 to 3: raw descriptors and neighbours on
//! their way in and out.
//!
//! Only what such arrays need is understood: little-endian numbers, row by row, as [`numpy.save`]
//! writes them. The crates that read all of the format recurse into nested headers and overflow the
//! stack on hostile ones.
//!
//! [`numpy.save`]: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html

use std::io::{self, Read};
use thiserror::Error;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// NumPy itself refuses longer headers of files that it does not trust.
const LONGEST_HEADER: u32 = 10_000;
/// Values are read in pieces of this many, so that a header alone makes nobody allocate much.
const PIECE: usize = 1 << 18;

/// The numbers that an array holds, as NumPy names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NpyType {
    /// `<f4`: floating point numbers of 4 bytes.
    F32,
    /// `<u4`: integers of 4 bytes.
    U32,
}

impl NpyType {
    fn name(self) -> &'static str {
        match self {
            Self::F32 => "<f4",
            Self::U32 => "<u4",
        }
    }
}

/// The header of an array of rows; their values, 4 bytes each, follow it row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NpyHeader {
    /// What the values are.
    pub element: NpyType,
    /// How many rows there are.
    pub rows: u64,
    /// How many values a row has.
    pub columns: u64,
    /// Where the values begin, in bytes from the beginning of the file.
    pub offset: u64,
}

/// An array that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NpyError {
    /// It cannot be read.
    #[error("cannot read it")]
    Io(#[from] io::Error),
    /// It does not begin as a `.npy` file does, or its header makes no sense.
    #[error("not a .npy file ({0}): write one with numpy.save")]
    NotNpy(&'static str),
    /// It is of a version that is not known.
    #[error("a .npy file of version {0}.{1}: save it with version 1.0, 2.0 or 3.0")]
    Version(u8, u8),
    /// It holds other numbers.
    #[error("its values are {found}, {wanted} is needed: convert them with astype('{wanted}')")]
    Element {
        /// The values' type, as the header has it.
        found: String,
        /// The type that is needed.
        wanted: &'static str,
    },
    /// Its values lie column by column.
    #[error("its values lie column by column (Fortran order): save numpy.ascontiguousarray(...) of it")]
    ColumnByColumn,
    /// It has no rows and columns.
    #[error("its shape is {0}: (rows, columns) is needed, or (columns,) for a single row")]
    Shape(String),
    /// Rows have another length.
    #[error("its rows have {found} values, {expected} are needed")]
    Columns {
        /// Values that a row has.
        found: u64,
        /// Values that it should have.
        expected: usize,
    },
    /// It has fewer values than its header says.
    #[error("truncated: {expected} bytes of values expected, {found} found: copy or write the file again")]
    Truncated {
        /// How many bytes its header promises; more than can be counted are `u64::MAX`.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// A value is infinite or no number.
    #[error("row {row} (counted from 0) holds {value} in column {column}: leave such rows out")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// What it is.
        value: f32,
    },
}

impl NpyHeader {
    /// Reads the header of an array of `element`s; `reader` is then at the first value.
    ///
    /// # Errors
    /// [`NpyError`], when it is no such array.
    pub fn read(reader: &mut impl Read, element: NpyType) -> Result<Self, NpyError> {
        let mut start = [0u8; 8];
        read_header_bytes(reader, &mut start)?;
        let [magic @ .., major, minor] = start;
        if magic != *MAGIC {
            return Err(NpyError::NotNpy("it begins otherwise"));
        }
        let (length, before) = match (major, minor) {
            (1, 0) => {
                let mut length = [0u8; 2];
                read_header_bytes(reader, &mut length)?;
                (u32::from(u16::from_le_bytes(length)), 10)
            }
            (2 | 3, 0) => {
                let mut length = [0u8; 4];
                read_header_bytes(reader, &mut length)?;
                (u32::from_le_bytes(length), 12)
            }
            _ => return Err(NpyError::Version(major, minor)),
        };
        if length > LONGEST_HEADER {
            return Err(NpyError::NotNpy("its header is longer than any header of an array is"));
        }
        let mut text = vec![0; length as usize];
        read_header_bytes(reader, &mut text)?;
        let text = std::str::from_utf8(&text).map_err(|_| NpyError::NotNpy("its header is not text"))?;
        let (rows, columns) = interpret(text, element)?;
        Ok(Self { element, rows, columns, offset: before + u64::from(length) })
    }

    /// The header as it is written; the values' place after it is a multiple of 64.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (element, rows, columns) = (self.element.name(), self.rows, self.columns);
        let text =
            format!("{{'descr': '{element}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
        // The dictionary ends in a newline, with spaces before it.
        let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
        let mut bytes = Vec::from(MAGIC);
        bytes.extend([1, 0]);
        bytes.extend((length as u16).to_le_bytes());
        bytes.extend(format!("{text:<width$}\n", width = length - 1).bytes());
        bytes
    }

    /// How many bytes the values take.
    ///
    /// # Errors
    /// [`NpyError::Truncated`], where that is more than can be counted: no file holds them.
    pub fn value_bytes(&self) -> Result<u64, NpyError> {
        let count = self.rows.checked_mul(self.columns).and_then(|values| values.checked_mul(4));
        count.ok_or(NpyError::Truncated { expected: u64::MAX, found: 0 })
    }

    /// Reads the values that follow the header of an array of [`NpyType::F32`], and checks that
    /// they are finite.
    ///
    /// # Errors
    /// [`NpyError`], when values are missing or are not finite.
    pub fn read_values(&self, reader: &mut impl Read) -> Result<Vec<f32>, NpyError> {
        let expected = self.value_bytes()?;
        let total = usize::try_from(expected / 4).map_err(|_| NpyError::Truncated { expected, found: 0 })?;
        let mut values = Vec::new();
        while values.len() < total {
            let done = values.len();
            values.resize(total.min(done + PIECE), 0.0f32);
            let read =
                read_as_much(reader, bytemuck::cast_slice_mut(values.get_mut(done..).unwrap_or_default()))?;
            if done + read / 4 < values.len() {
                return Err(NpyError::Truncated { expected, found: (4 * done + read) as u64 });
            }
        }
        check_finite(&values, self.columns as usize)?;
        Ok(values)
    }
}

/// Checks that all values of rows of `columns` are finite.
///
/// # Errors
/// [`NpyError::NotFinite`] names the first that is not.
pub fn check_finite(values: &[f32], columns: usize) -> Result<(), NpyError> {
    let found = values.iter().enumerate().find(|(_, value)| !value.is_finite());
    found.map_or(Ok(()), |(at, &value)| {
        let columns = columns.max(1);
        Err(NpyError::NotFinite { row: at / columns, column: at % columns, value })
    })
}

fn read_header_bytes(reader: &mut impl Read, bytes: &mut [u8]) -> Result<(), NpyError> {
    match reader.read_exact(bytes) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            Err(NpyError::NotNpy("it ends too soon"))
        }
        other => Ok(other?),
    }
}

/// Fills `bytes` as far as the reader has any.
fn read_as_much(reader: &mut impl Read, mut bytes: &mut [u8]) -> io::Result<usize> {
    let wanted = bytes.len();
    while !bytes.is_empty() {
        match reader.read(bytes) {
            Ok(0) => break,
            Ok(read) => bytes = bytes.get_mut(read..).unwrap_or_default(),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(wanted - bytes.len())
}

/// Rows and columns of an array of `element`s with the header `text`, a Python dictionary.
fn interpret(text: &str, element: NpyType) -> Result<(u64, u64), NpyError> {
    let descr = value(text, "descr")?;
    if descr.trim_matches(['\'', '"']) != element.name() {
        let found = descr.chars().filter(|character| !character.is_control()).take(80).collect();
        return Err(NpyError::Element { found, wanted: element.name() });
    }
    match value(text, "fortran_order")? {
        "False" => {}
        // Of an array with one axis both orders are the same.
        "True" if single(value(text, "shape")?) => {}
        "True" => return Err(NpyError::ColumnByColumn),
        _ => return Err(NpyError::NotNpy("its header names no order")),
    }
    let shape = value(text, "shape")?;
    let sizes: Option<Vec<u64>> = shape
        .strip_prefix('(')
        .and_then(|shape| shape.strip_suffix(')'))
        .map(|sizes| sizes.strip_suffix(',').unwrap_or(sizes))
        .and_then(|sizes| sizes.split(',').map(|size| size.trim().parse().ok()).collect());
    match sizes.as_deref() {
        Some(&[columns]) => Ok((1, columns)),
        Some(&[rows, columns]) => Ok((rows, columns)),
        _ => {
            Err(NpyError::Shape(shape.chars().filter(|character| !character.is_control()).take(80).collect()))
        }
    }
}

/// Whether a shape has one axis: a single row, whatever the order.
fn single(shape: &str) -> bool {
    !shape.trim_end_matches([',', ')', ' ']).contains(',')
}

/// The value of `key`: what stands between its colon and the comma or brace that ends it, outside
/// of brackets and quotes.
fn value<'t>(text: &'t str, key: &str) -> Result<&'t str, NpyError> {
    let missing = NpyError::NotNpy("its header is incomplete");
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let Some(after) = quoted.iter().find_map(|key| text.split_once(key.as_str())).map(|(_, after)| after)
    else {
        return Err(missing);
    };
    let Some(after) = after.trim_start().strip_prefix(':') else {
        return Err(missing);
    };
    let (mut depth, mut quote) = (0i32, None);
    for (at, character) in after.char_indices() {
        match (quote, character) {
            (Some(open), close) if open == close => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(character),
            (None, '(' | '[') => depth += 1,
            (None, ')' | ']') => depth -= 1,
            (None, ',' | '}') if depth <= 0 => return Ok(after.get(..at).unwrap_or_default().trim()),
            _ => {}
        }
    }
    Err(missing)
}

#[cfg(test)]
mod tests;
