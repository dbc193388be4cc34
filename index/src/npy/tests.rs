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
    assert_eq!(read(&second).expect("an array").1, values);
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
    assert_snapshot!(error("{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (1, 2), }"), @"its values are [('x', '<f4')], <f4 is needed: convert them with astype('<f4')");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }"), @"its values lie column by column (Fortran order): save numpy.ascontiguousarray(...) of it");
    assert_snapshot!(error("{'descr': '<f4', 'fortran_order': False, 'shape': (), }"), @"its shape is (): (rows, columns) is needed, or (columns,) for a single row");
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
