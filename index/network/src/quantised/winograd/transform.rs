//! The transforms of F(2 x 2, 3 x 3), of rows and then of columns, for many planes or outputs at
//! once.
//!
//! Indexed loops of a length that is known become vector instructions here, and iterators and
//! closures do not: run examples/network_speed.rs after a change.

/// Pixels a side of the window that a tile reads.
pub(super) const WINDOW: usize = 4;
/// Pixels a side of a kernel.
pub(super) const KERNEL: usize = 3;
/// Places of a window.
pub(super) const PLACES: usize = WINDOW * WINDOW;
/// Planes that are transformed together.
pub(super) const PLANES: usize = 16;

/// Transforms the window that a tile reads, row by row.
#[inline(always)]
pub(super) fn of_inputs<const N: usize>(window: [&[i16; N]; PLACES]) -> [[i16; N]; PLACES] {
    let line = |a, b, c, d| [a - c, b + c, c - b, b - d];
    let mut transformed = [[0; N]; PLACES];
    for lane in 0..N {
        let mut rows = [[0; WINDOW]; WINDOW];
        for y in 0..WINDOW {
            let at = |x: usize| window[y * WINDOW + x][lane];
            rows[y] = line(at(0), at(1), at(2), at(3));
        }
        for x in 0..WINDOW {
            let column = line(rows[0][x], rows[1][x], rows[2][x], rows[3][x]);
            for y in 0..WINDOW {
                transformed[y * WINDOW + x][lane] = column[y];
            }
        }
    }
    transformed
}

/// Transforms kernels, row by row: into four times what the paper has, which are no integers.
pub(super) fn of_weights<const N: usize>(kernels: &[[i16; N]; KERNEL * KERNEL]) -> [[i16; N]; PLACES] {
    let line = |a, b, c| [2 * a, a + b + c, a - b + c, 2 * c];
    let mut transformed = [[0; N]; PLACES];
    for lane in 0..N {
        let mut rows = [[0; WINDOW]; KERNEL];
        for y in 0..KERNEL {
            let at = |x: usize| kernels[y * KERNEL + x][lane];
            rows[y] = line(at(0), at(1), at(2));
        }
        for x in 0..WINDOW {
            let column = line(rows[0][x], rows[1][x], rows[2][x]);
            for y in 0..WINDOW {
                transformed[y * WINDOW + x][lane] = column[y];
            }
        }
    }
    transformed
}

/// Transforms a tile's sums of products into what its 2 x 2 outputs sum, row by row.
#[inline(always)]
pub(super) fn of_sums<const N: usize>(sums: [&[i32; N]; PLACES]) -> [[i32; N]; 4] {
    let line = |a, b, c, d| [a + b + c, b - c - d];
    let mut outputs = [[0; N]; 4];
    for lane in 0..N {
        let mut rows = [[0; 2]; WINDOW];
        for y in 0..WINDOW {
            let at = |x: usize| sums[y * WINDOW + x][lane];
            rows[y] = line(at(0), at(1), at(2), at(3));
        }
        for x in 0..2 {
            let column = line(rows[0][x], rows[1][x], rows[2][x], rows[3][x]);
            for y in 0..2 {
                // A multiple of 4, as the weights were: nothing is lost.
                outputs[2 * y + x][lane] = column[y] >> 2;
            }
        }
    }
    outputs
}
