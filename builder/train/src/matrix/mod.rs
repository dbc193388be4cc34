//! Products of matrices.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod view;

pub(crate) use view::Matrix;

/// What becomes of the values that a product is written over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Before {
    /// They are replaced.
    Replace,
    /// The product is added to them.
    Add,
}

/// Writes `left * right` to `out`, row by row. One thread, and always the same order of summation
/// for the same sizes.
pub(crate) fn multiply(left: Matrix<'_>, right: Matrix<'_>, before: Before, out: &mut [f32]) {
    assert_eq!(left.columns, right.rows, "inner sizes");
    assert_eq!(out.len(), left.rows * right.columns, "the product's size");
    left.check();
    right.check();
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the processor has the instructions.
        unsafe { avx512::multiply(left, right, before == Before::Add, out) };
        return;
    }
    multiply_anywhere(left, right, before, out);
}

/// On processors without AVX-512.
fn multiply_anywhere(left: Matrix<'_>, right: Matrix<'_>, before: Before, out: &mut [f32]) {
    let keep = if before == Before::Add { 1.0 } else { 0.0 };
    // SAFETY: the caller has checked that every element of both factors lies in its slice, and that
    // `out` has `rows * columns` values; it is borrowed mutably, so that it overlaps neither.
    unsafe {
        matrixmultiply::sgemm(
            left.rows,
            left.columns,
            right.columns,
            1.0,
            left.values.as_ptr(),
            left.row_stride as isize,
            left.column_stride as isize,
            right.values.as_ptr(),
            right.row_stride as isize,
            right.column_stride as isize,
            keep,
            out.as_mut_ptr(),
            right.columns as isize,
            1,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small integers, of which all sums are exact.
    fn integers(count: usize) -> Vec<f32> {
        (0..count).map(|i| ((i * 31 % 17) as f32) - 8.0).collect()
    }

    #[test]
    fn products_are_those_of_the_definition() {
        let sizes = [(1, 1, 1), (8, 128, 48), (9, 129, 49), (17, 300, 15), (50, 20, 16), (3, 7, 100)];
        for (rows, inner, columns) in sizes {
            let (a, b) = (integers(rows * inner), integers(inner * columns));
            let mut expected = integers(rows * columns);
            for (at, value) in expected.iter_mut().enumerate() {
                let (row, column) = (at / columns, at % columns);
                *value += (0..inner).map(|i| a[row * inner + i] * b[i * columns + column]).sum::<f32>();
            }
            // Each factor as it is, and as the transpose of its transpose.
            let flip = |values: &[f32], rows: usize, columns: usize| -> Vec<f32> {
                (0..rows * columns).map(|at| values[at % rows * columns + at / rows]).collect()
            };
            let (at, bt) = (flip(&a, rows, inner), flip(&b, inner, columns));
            let lefts = [Matrix::new(&a, rows, inner), Matrix::new(&at, inner, rows).transposed()];
            let rights = [Matrix::new(&b, inner, columns), Matrix::new(&bt, columns, inner).transposed()];
            for (left, right) in lefts.iter().flat_map(|left| rights.iter().map(move |right| (left, right))) {
                for product in [multiply, multiply_anywhere] {
                    let mut out = integers(rows * columns);
                    product(*left, *right, Before::Add, &mut out);
                    assert_eq!(out, expected, "{rows} {inner} {columns}");
                    let once = integers(rows * columns);
                    product(*left, *right, Before::Replace, &mut out);
                    assert!(out.iter().zip(&once).zip(&expected).all(|((o, once), all)| o + once == *all));
                }
            }
        }
    }

    #[test]
    fn some_columns_are_a_matrix_too() {
        let values = integers(12);
        let mut out = [0.0; 3];
        let part = Matrix::new(&values, 3, 4).columns(1..3);
        multiply(part, Matrix::new(&[1.0, 10.0], 2, 1), Before::Replace, &mut out);
        assert_eq!(out, [0, 1, 2].map(|row| values[row * 4 + 1] + 10.0 * values[row * 4 + 2]));
    }
}
