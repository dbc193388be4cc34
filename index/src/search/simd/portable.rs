//! Vectors of the crate `wide` and plain loops: what the other paths must agree with.

use crate::search::blocks::{Blocks, CodeBits, LANES, QuantisedQuery};
use crate::search::distance;
use wide::{i16x8, i32x4, u8x16};

/// The compiler sees no instruction that multiplies four bytes by four values and adds the products;
/// two of 16 bits every processor's vectors have.
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut [f32]) {
    let bias = query.bias(run.bits());
    for (block, into) in run.iter().zip(into.as_chunks_mut::<LANES>().0) {
        // Two sums for each of sixteen vectors: of the even pairs of axes, and of the odd ones.
        let mut sums = [i32x4::ZERO; LANES / 2];
        let groups = block.codes.as_chunks::<{ 4 * LANES }>().0.iter();
        match run.bits() {
            CodeBits::Four => {
                for (codes, [low, high]) in groups.zip(query.values.as_chunks().0.as_chunks().0) {
                    add_products(&codes.map(|code| code & 15), *low, &mut sums);
                    add_products(&codes.map(|code| code >> 4), *high, &mut sums);
                }
            }
            CodeBits::Eight => {
                for (codes, values) in groups.zip(query.values.as_chunks().0) {
                    add_products(codes, *values, &mut sums);
                }
            }
        }
        let dots = sums.iter().flat_map(|sums| {
            let [even, odd, next_even, next_odd] = sums.to_array();
            [even.wrapping_add(odd), next_even.wrapping_add(next_odd)]
        });
        for ((score, dot), &scalar) in into.iter_mut().zip(dots).zip(block.scalars) {
            *score = base + (scalar - factor * dot.wrapping_sub(bias) as f32);
        }
    }
}

pub(super) fn near(scores: &[f32], bound: f32, into: &mut Vec<u32>) {
    into.clear();
    for (block, scores) in scores.as_chunks::<LANES>().0.iter().enumerate() {
        // Most blocks have none, which vectors show faster than a branch for each.
        let mut any = false;
        for &score in scores {
            any |= score <= bound;
        }
        if any {
            let places = (LANES * block) as u32..;
            into.extend(places.zip(scores).filter_map(|(place, &score)| (score <= bound).then_some(place)));
        }
    }
}

/// Adds the products of four axes of sixteen vectors and the query's four values.
#[inline(always)]
fn add_products(codes: &[u8; 4 * LANES], [a, b, c, d]: [i16; 4], sums: &mut [i32x4; LANES / 2]) {
    let values = i16x8::new([a, b, c, d, a, b, c, d]);
    for (codes, sums) in codes.as_chunks::<16>().0.iter().zip(sums.as_chunks_mut::<2>().0) {
        let codes = u8x16::new(*codes);
        sums[0] += i16x8::from_u8x16_low(codes).dot(values);
        sums[1] += i16x8::from_u8x16_high(codes).dot(values);
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
