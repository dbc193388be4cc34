//! Plain loops: what the other paths must agree with.

use crate::search::blocks::{Blocks, LANES, QuantisedQuery};
use crate::search::distance;
use crate::search::smallest::Smallest;

pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut Smallest) {
    for block in run.iter() {
        let mut dots = [0i32; LANES];
        for (codes, values) in block.codes.chunks_exact(4 * LANES).zip(query.values.chunks_exact(4)) {
            for (dot, codes) in dots.iter_mut().zip(codes.chunks_exact(4)) {
                for (&code, &value) in codes.iter().zip(values) {
                    *dot = dot.wrapping_add(i32::from(code).wrapping_mul(i32::from(value)));
                }
            }
        }
        let mut mask = 0u16;
        let mut scores = [0.0f32; LANES];
        for (lane, (&dot, &scalar)) in dots.iter().zip(block.scalars).enumerate() {
            scores[lane] = base + (scalar - factor * dot.wrapping_sub(query.bias) as f32);
            mask |= u16::from(scores[lane] <= into.bound()) << lane;
        }
        into.offer(&block, &scores, mask);
    }
}

#[inline(always)]
pub(super) fn distances<'a>(
    query: &[f32],
    rows: impl Iterator<Item = &'a [f32]>,
    mut each: impl FnMut(usize, f32),
) {
    for (at, row) in rows.enumerate() {
        each(at, distance::squared(query, row));
    }
}

/// Adds to each coordinate what each value of `vector` gives it, value by value: row `d` of
/// `matrix` holds what value `d` gives to each of `out.len()` coordinates. The compiler makes
/// vector instructions of it, and the order of the sums is the same with any.
#[inline(always)]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    let axes = out.len();
    let (fours, rest) = out.as_chunks_mut::<{ 4 * LANES }>();
    for (start, out) in (0..).step_by(4 * LANES).zip(&mut *fours) {
        // Four registers of sixteen, or as many of smaller ones as make the same.
        columns(matrix, axes, start, offset, vector, out);
    }
    let start = fours.len() * 4 * LANES;
    let (sixteens, rest) = rest.as_chunks_mut::<LANES>();
    for (start, out) in (start..).step_by(LANES).zip(&mut *sixteens) {
        columns(matrix, axes, start, offset, vector, out);
    }
    let start = start + sixteens.len() * LANES;
    let (fours, rest) = rest.as_chunks_mut::<4>();
    for (start, out) in (start..).step_by(4).zip(&mut *fours) {
        columns(matrix, axes, start, offset, vector, out);
    }
    let start = start + fours.len() * 4;
    for (start, out) in (start..).zip(rest) {
        columns(matrix, axes, start, offset, vector, std::array::from_mut(out));
    }
}

/// The coordinates of `N` neighbouring columns of the matrix, from `start` on.
#[inline(always)]
fn columns<const N: usize>(
    matrix: &[f32],
    axes: usize,
    start: usize,
    offset: &[f32],
    vector: &[f32],
    out: &mut [f32; N],
) {
    let mut sums = [0.0f32; N];
    for (row, &value) in matrix.chunks_exact(axes).zip(vector) {
        let Some(row) = row[start..].first_chunk::<N>() else { break };
        for (sum, factor) in sums.iter_mut().zip(row) {
            *sum += value * factor;
        }
    }
    let offset = offset.get(start..).unwrap_or(&[]).iter().chain(std::iter::repeat(&0.0));
    for ((out, sum), offset) in out.iter_mut().zip(sums).zip(offset) {
        *out = sum + offset;
    }
}
