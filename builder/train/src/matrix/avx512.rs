//! Products of matrices with AVX-512.
//!
//! The products of training are small in two of three sizes, so that the general libraries spend
//! half of the time on packing. Here only a narrow panel of the right factor is packed; the left
//! one is read in place, value by value, each multiplied with a whole row of the panel.
//!
//! The inner loops have neither pointers nor index arithmetic: a build with debug assertions checks
//! those one by one, which took more time than the products.

use super::view::Matrix;
use std::arch::x86_64::{__m512, _mm512_add_ps, _mm512_fmadd_ps, _mm512_set1_ps, _mm512_setzero_ps};
use std::array::from_fn;
use std::ops::Range;

/// Values of a register.
const LANES: usize = 16;
/// Columns of a panel: three registers, so that [`ROWS`] rows of sums take 24 of the 32.
const WIDTH: usize = 3 * LANES;
/// Rows of a panel, which then fills half of the first-level cache.
const DEPTH: usize = 128;
/// Rows of the product that are summed at once.
const ROWS: usize = 8;

/// Some rows and columns of the right factor; the columns that it does not have are 0.
#[repr(align(64))]
struct Panel([[f32; WIDTH]; DEPTH]);

impl Panel {
    fn pack(&mut self, right: Matrix<'_>, start: usize, depth: usize, first: usize, width: usize) {
        for (row, target) in (start..).zip(&mut self.0[..depth]) {
            let source = &right.values[row * right.row_stride + first * right.column_stride..];
            target[width..].fill(0.0);
            if right.column_stride == 1 {
                target[..width].copy_from_slice(&source[..width]);
                continue;
            }
            for (to, from) in target[..width].iter_mut().zip(source.iter().step_by(right.column_stride)) {
                *to = *from;
            }
        }
    }
}

/// Writes `left * right` to `out`, or adds it to what is there.
#[target_feature(enable = "avx512f")]
pub(super) fn multiply(left: Matrix<'_>, right: Matrix<'_>, add: bool, out: &mut [f32]) {
    let mut panel = Panel([[0.0; WIDTH]; DEPTH]);
    for Range { start: first, end } in panels(right.columns) {
        let width = end - first;
        for start in (0..left.columns).step_by(DEPTH) {
            let depth = DEPTH.min(left.columns - start);
            panel.pack(right, start, depth, first, width);
            let place = Place { start, first, width, add: add || start > 0, stride: right.columns };
            let panel = &panel.0[..depth];
            match width.div_ceil(LANES) {
                1 => all_rows::<1>(left, panel, place, out),
                2 => all_rows::<2>(left, panel, place, out),
                _ => all_rows::<3>(left, panel, place, out),
            }
        }
    }
}

/// The columns of each panel: as few panels as there can be, all about as wide, because a narrow
/// one makes less use of what is read of the left factor.
fn panels(columns: usize) -> impl Iterator<Item = Range<usize>> {
    let registers = columns.div_ceil(LANES);
    let count = columns.div_ceil(WIDTH);
    let start = move |panel: usize| (panel * registers / count * LANES).min(columns);
    (0..count).map(move |panel| start(panel)..start(panel + 1))
}

/// Which part of a product is computed.
#[derive(Clone, Copy)]
struct Place {
    /// The first column of the left factor.
    start: usize,
    /// The first column of the product.
    first: usize,
    /// Its columns.
    width: usize,
    /// Whether the sums are added to what is there.
    add: bool,
    /// All columns of the product.
    stride: usize,
}

/// All rows of a part of the product whose width fits into `V` registers.
#[target_feature(enable = "avx512f")]
fn all_rows<const V: usize>(left: Matrix<'_>, panel: &[[f32; WIDTH]], place: Place, out: &mut [f32]) {
    let groups = left.rows / ROWS;
    for group in 0..groups {
        rows::<ROWS, V>(left, group * ROWS, panel, place, out);
    }
    for row in groups * ROWS..left.rows {
        rows::<1, V>(left, row, panel, place, out);
    }
}

/// `R` rows of it, from row `row`.
#[target_feature(enable = "avx512f")]
fn rows<const R: usize, const V: usize>(
    left: Matrix<'_>,
    row: usize,
    panel: &[[f32; WIDTH]],
    place: Place,
    out: &mut [f32],
) {
    let values = &left.values[row * left.row_stride + place.start * left.column_stride..];
    let sums = if left.column_stride == 1 {
        let lines: [&[f32]; R] = from_fn(|r| &values[r * left.row_stride..][..panel.len()]);
        sums::<R, V>((0..panel.len()).map(|at| from_fn(|r| lines[r][at])), panel)
    } else if left.row_stride == 1 {
        // The rows of a transposed factor lie side by side.
        let lines = values.chunks(left.column_stride).filter_map(<[f32]>::first_chunk);
        sums::<R, V>(lines.copied(), panel)
    } else {
        let value = |r, at| values[r * left.row_stride + at * left.column_stride];
        sums::<R, V>((0..panel.len()).map(|at| from_fn(|r| value(r, at))), panel)
    };
    for (r, sums) in sums.iter().enumerate() {
        let line = &mut out[(row + r) * place.stride + place.first..][..place.width];
        write(sums, line, place.add);
    }
}

/// The sums of the products of each of `R` rows, given column by column, with the panel.
#[inline]
#[target_feature(enable = "avx512f")]
fn sums<const R: usize, const V: usize>(
    left: impl Iterator<Item = [f32; R]>,
    panel: &[[f32; WIDTH]],
) -> [[__m512; V]; R] {
    let mut sums = [[_mm512_setzero_ps(); V]; R];
    for (values, line) in left.zip(panel) {
        let (line, _) = line.as_chunks();
        let mut right = [_mm512_setzero_ps(); V];
        for v in 0..V {
            right[v] = register(line[v]);
        }
        for r in 0..R {
            let value = _mm512_set1_ps(values[r]);
            for v in 0..V {
                sums[r][v] = _mm512_fmadd_ps(value, right[v], sums[r][v]);
            }
        }
    }
    sums
}

/// Writes or adds the registers' values to a line, which may be shorter.
#[inline]
#[target_feature(enable = "avx512f")]
fn write<const V: usize>(sums: &[__m512; V], line: &mut [f32], add: bool) {
    let (whole, rest) = line.as_chunks_mut();
    for (sum, line) in sums.iter().zip(&mut *whole) {
        *line = lanes(if add { _mm512_add_ps(register(*line), *sum) } else { *sum });
    }
    if let Some(sum) = sums.get(whole.len()) {
        write_part(*sum, rest, add);
    }
}

/// The same of the last register, where the line ends within it. Apart, so that the common case
/// becomes part of the loops.
#[cold]
#[inline(never)]
#[target_feature(enable = "avx512f")]
fn write_part(sum: __m512, line: &mut [f32], add: bool) {
    for (value, sum) in line.iter_mut().zip(lanes(sum)) {
        *value = if add { *value + sum } else { sum };
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn register(lanes: [f32; LANES]) -> __m512 {
    // SAFETY: both are 16 values of f32, and every bit pattern is valid for both.
    unsafe { std::mem::transmute::<[f32; LANES], __m512>(lanes) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn lanes(register: __m512) -> [f32; LANES] {
    // SAFETY: as above.
    unsafe { std::mem::transmute::<__m512, [f32; LANES]>(register) }
}
