//! The format against what NumPy writes, and against what nobody should.

use super::*;
use insta::assert_snapshot;
use proptest::prelude::*;

/// An array with the header `text`, as version 1.
fn array(text: &str, values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::from(MAGIC);
    bytes.extend([1, 0]);
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn read(mut bytes: &[u8]) -> Result<(NpyHeader, Vec<f32>), NpyError> {
    let header = NpyHeader::read(&mut bytes, NpyType::F32)?;
    Ok((header, header.read_values(&mut bytes)?))
}

fn error(text: &str) -> String {
    read(&array(text, &[1.0, 2.0])).expect_err("the header is wrong").to_string()
}

/// Byte for byte what `numpy.save` wrote of `numpy.array([[1, 2, 3]], dtype='<f4')`, and of the
/// same with version 2.
#[test]
fn what_numpy_writes_is_read() {
    let text = format!("{:<117}\n", "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }");
    let by_numpy = array(&text, &[1.0, 2.0, 3.0]);
    let (header, values) = read(&by_numpy).expect("an array");
    assert_eq!((header.rows, header.columns, header.offset), (1, 3, 128));
    assert_eq!(values, [1.0, 2.0, 3.0]);
    let mut second = Vec::from(MAGIC);
    second.extend([2, 0]);
    second.extend((text.len() as u32).to_le_bytes());
    second.extend(&by_numpy[10..]);
    let (header, found) = read(&second).expect("an array");
    assert_eq!((header.offset, found), (130, values));
}

/// Gives what a pipe may: pieces of any length, interruptions, and an error in the end.
struct Pipe<'a> {
    bytes: &'a [u8],
    piece: usize,
    is_interrupted: bool,
}

impl Read for Pipe<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.is_interrupted = !self.is_interrupted;
        if self.is_interrupted {
            return Err(io::ErrorKind::Interrupted.into());
        }
        if self.bytes.is_empty() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let length = self.piece.min(into.len());
        self.bytes.read(&mut into[..length])
    }
}

#[test]
fn a_pipe_gives_all_its_values_or_says_why_not() {
    let values: Vec<f32> = (0..2 * PIECE + 3).map(|value| value as f32).collect();
    let text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, 1), }}", values.len());
    let whole = array(&text, &values);
    let of_pipe = |bytes| {
        let mut pipe = Pipe { bytes, piece: 65_535, is_interrupted: false };
        let header = NpyHeader::read(&mut pipe, NpyType::F32)?;
        header.read_values(&mut pipe)
    };
    assert!(of_pipe(&whole).expect("an array") == values);
    for length in [7, 40, whole.len() - 1] {
        let error = of_pipe(&whole[..length]).expect_err("the pipe breaks");
        assert!(matches!(&error, NpyError::Io(why) if why.kind() == io::ErrorKind::BrokenPipe), "{error}");
    }
    // A file that ends in the second piece, within a value.
    let missing = 4 * PIECE + 2;
    let error = read(&whole[..whole.len() - missing]).expect_err("values are missing");
    let found = (4 * values.len() - missing) as u64;
    assert!(matches!(error, NpyError::Truncated { found: is, .. } if is == found), "{error}, not {found}");
}

#[test]
fn a_value_that_is_not_finite_has_its_row_and_column() {
    let mut values = [0.5; 12];
    values[7] = f32::NEG_INFINITY;
    values[11] = f32::NAN;
    let at = |columns| match check_finite(&values, columns) {
        Err(NpyError::NotFinite { row, column, value: f32::NEG_INFINITY }) => (row, column),
        other => panic!("{other:?}"),
    };
    assert_eq!((at(4), at(3), at(1)), ((1, 3), (2, 1), (7, 0)));
    assert!(check_finite(&values[..7], 4).is_ok());
}

#[test]
fn a_vector_is_one_row_in_either_order() {
    for order in ["False", "True"] {
        let text = format!("{{'descr': '<f4', 'fortran_order': {order}, 'shape': (2,), }}\n");
        let (header, _) = read(&array(&text, &[1.0, 2.0])).expect("an array");
        assert_eq!((header.rows, header.columns), (1, 2));
    }
}

#[test]
fn messages() {
    let empty = read(b"").expect_err("no file");
    assert_snapshot!(empty, @"not a .npy file (it ends too soon): write one with numpy.save");
    let other = read(b"GIF89a and so on").expect_err("a picture");
    assert_snapshot!(other, @"not a .npy file (it begins otherwise): write one with numpy.save");
    let version = read(b"\x93NUMPY\x09\x00      ").expect_err("an unknown version");
    assert_snapshot!(version, @"a .npy file of version 9.0: save it with version 1.0, 2.0 or 3.0");
    assert_snapshot!(error("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }"), @"its values are '<f8', <f4 is needed: convert them with astype('<f4')");
    assert_snapshot!(error("{'descr': [('x', '<f4'), ('y', '<f4')], 'fortran_order': False, 'shape': (1,), }"), @"its values are [('x', '<f4'), ('y', '<f4')], <f4 is needed: convert them with astype('<f4')");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }"), @"its values lie column by column (Fortran order): save numpy.ascontiguousarray(...) of it");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': False, 'shape': (), }"), @"its shape is (): (rows, columns) is needed, or (columns,) for a single row");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': True, 'shape': (), }"), @"its shape is (): (rows, columns) is needed, or (columns,) for a single row");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 1), }"), @"its shape is (1, 2, 1): (rows, columns) is needed, or (columns,) for a single row");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }"), @"truncated: 16 bytes of values expected, 8 found: copy or write the file again");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': False, 'shape': (9223372036854775807, 84), }"), @"truncated: 18446744073709551615 bytes of values expected, 0 found: copy or write the file again");
    assert_snapshot!(error("{'descr': '<f4', 'shape': (1, 2), }"), @"not a .npy file (its header is incomplete): write one with numpy.save");
    let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }";
    let not_finite = read(&array(text, &[1.0, 2.0, 3.0, f32::NAN])).expect_err("a NaN");
    assert_snapshot!(not_finite, @"row 1 (counted from 0) holds NaN in column 1: leave such rows out");
}

#[test]
fn hostile_headers_do_no_harm() {
    for open in ["(", "[", "{", "'", "\"", "{'descr':", "'shape': (", ","] {
        let text = open.repeat(9_000 / open.len());
        read(&array(&text, &[])).expect_err("no header");
    }
    let mut long = Vec::from(MAGIC);
    long.extend([2, 0, 0xff, 0xff, 0xff, 0xff]);
    let error = read(&long).expect_err("a header of 4 GiB");
    assert_snapshot!(error, @"not a .npy file (its header is longer than any header of an array is): write one with numpy.save");
    // A promise of 4 exabytes allocates no more than there is.
    read(&array("{'descr': '<f4', 'fortran_order': False, 'shape': (1099511627776, 1048576), }", &[]))
        .expect_err("nothing follows");
}

proptest! {
    #[test]
    fn what_is_written_is_read(rows in 0..40u64, columns in 1..40u64) {
        let values: Vec<f32> = (0..rows * columns).map(|value| value as f32 / 3.0).collect();
        let header = NpyHeader { element: NpyType::F32, rows, columns, offset: 128 };
        let mut bytes = header.to_bytes();
        prop_assert_eq!(bytes.len() % 64, 0);
        let start = bytes.len() as u64;
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let (read, found) = read(&bytes).expect("an array");
        prop_assert_eq!(read, NpyHeader { offset: start, ..header });
        prop_assert_eq!(found, values);
    }

    #[test]
    fn noise_is_refused_without_harm(text in "[ '(){}\\[\\],:a-z0-9<]{0,200}") {
        let _ = read(&array(&format!("{{'descr': '<f4', 'fortran_order': False, {text}"), &[1.0]));
        let _ = read(&array(&text, &[1.0]));
    }
}
