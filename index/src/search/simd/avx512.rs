//! AVX-512 with VNNI: one register holds four axes of sixteen vectors, and one instruction
//! multiplies them by four values of the query and adds the products up.

use super::{avx2, portable};
use crate::search::blocks::{Blocks, LANES, QuantisedQuery};
use crate::search::distance;
use crate::search::smallest::Smallest;
use std::arch::x86_64::{
    __m512i, _CMP_LE_OQ, _mm256_add_ps, _mm256_castpd_ps, _mm512_add_epi32, _mm512_add_ps, _mm512_castps_pd,
    _mm512_castps512_ps256, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_dpbusd_epi32,
    _mm512_extractf64x4_pd, _mm512_loadu_ps, _mm512_loadu_si512, _mm512_mul_ps, _mm512_set1_epi32,
    _mm512_set1_ps, _mm512_setzero_ps, _mm512_setzero_si512, _mm512_slli_epi32, _mm512_storeu_ps,
    _mm512_sub_epi32, _mm512_sub_ps,
};

/// The instruction takes the query's values as signed bytes, so a value goes in as `128 * high +
/// low`.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut Smallest) {
    let (factor, base) = (_mm512_set1_ps(factor), _mm512_set1_ps(base));
    let bias = _mm512_set1_epi32(query.bias);
    let (halves, last_half) = query.halves.as_chunks::<2>();
    for block in run.iter() {
        let (groups, last) = block.codes.as_chunks::<{ 8 * LANES }>();
        // Two sums of each half: one instruction need not wait for the one before it.
        let mut sums = [[_mm512_setzero_si512(); 2]; 2];
        for (codes, halves) in groups.iter().zip(halves) {
            let (first, second) = (load(codes, 0), load(codes, 4 * LANES));
            sums[0][0] = _mm512_dpbusd_epi32(sums[0][0], first, _mm512_set1_epi32(halves[0][0]));
            sums[0][1] = _mm512_dpbusd_epi32(sums[0][1], first, _mm512_set1_epi32(halves[0][1]));
            sums[1][0] = _mm512_dpbusd_epi32(sums[1][0], second, _mm512_set1_epi32(halves[1][0]));
            sums[1][1] = _mm512_dpbusd_epi32(sums[1][1], second, _mm512_set1_epi32(halves[1][1]));
        }
        if let ([half], [_, ..]) = (last_half, last) {
            let codes = load(last, 0);
            sums[0][0] = _mm512_dpbusd_epi32(sums[0][0], codes, _mm512_set1_epi32(half[0]));
            sums[0][1] = _mm512_dpbusd_epi32(sums[0][1], codes, _mm512_set1_epi32(half[1]));
        }
        let high = _mm512_slli_epi32::<7>(_mm512_add_epi32(sums[0][0], sums[1][0]));
        let low = _mm512_add_epi32(sums[0][1], sums[1][1]);
        let dots = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_add_epi32(high, low), bias));
        // SAFETY: the scalars are an array of sixteen f32; an unaligned load takes any address.
        let scalars = unsafe { _mm512_loadu_ps(block.scalars.as_ptr()) };
        let scores = _mm512_add_ps(base, _mm512_sub_ps(scalars, _mm512_mul_ps(factor, dots)));
        let mask = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(scores, _mm512_set1_ps(into.bound()));
        if mask != 0 {
            let mut found = [0.0f32; LANES];
            // SAFETY: the array has room for sixteen f32; an unaligned store takes any address.
            unsafe { _mm512_storeu_ps(found.as_mut_ptr(), scores) };
            into.offer(&block, &found, mask);
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn load(codes: &[u8], at: usize) -> __m512i {
    let codes = &codes[at..at + 4 * LANES];
    // SAFETY: the slice has the register's 64 bytes; an unaligned load takes any address.
    unsafe { _mm512_loadu_si512(codes.as_ptr().cast()) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn distances<'a>(
    query: &[f32],
    rows: impl Iterator<Item = &'a [f32]>,
    mut each: impl FnMut(usize, f32),
) {
    for (at, row) in rows.enumerate() {
        each(at, squared(query, row));
    }
}

/// As [`distance::squared`], to the bit: differences, products and sums are rounded one by one, and
/// added in its order.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn squared(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = distance::alike(a, b);
    let ((whole_a, rest_a), (whole_b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = _mm512_setzero_ps();
    for (a, b) in whole_a.iter().zip(whole_b) {
        // SAFETY: both arrays have sixteen f32; an unaligned load takes any address.
        let step = unsafe { _mm512_sub_ps(_mm512_loadu_ps(a.as_ptr()), _mm512_loadu_ps(b.as_ptr())) };
        lanes = _mm512_add_ps(lanes, _mm512_mul_ps(step, step));
    }
    let upper = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(lanes)));
    avx2::sum_up(_mm256_add_ps(_mm512_castps512_ps256(lanes), upper), rest_a, rest_b)
}

/// As [`portable::project`], to the bit: products and sums are rounded one by one.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    const WIDTH: usize = 4 * LANES;
    let axes = out.len();
    if axes == 0 || !axes.is_multiple_of(WIDTH) || offset.len() != axes {
        return portable::project(matrix, offset, vector, out);
    }
    for (start, out) in (0..).step_by(WIDTH).zip(out.as_chunks_mut::<WIDTH>().0) {
        let mut sums = [_mm512_setzero_ps(); 4];
        for (row, &value) in matrix.chunks_exact(axes).zip(vector) {
            let value = _mm512_set1_ps(value);
            let row = row[start..start + WIDTH].as_chunks::<LANES>().0;
            for (sum, row) in sums.iter_mut().zip(row) {
                // SAFETY: the array has sixteen f32; an unaligned load takes any address.
                let row = unsafe { _mm512_loadu_ps(row.as_ptr()) };
                *sum = _mm512_add_ps(*sum, _mm512_mul_ps(value, row));
            }
        }
        let offsets = offset[start..start + WIDTH].as_chunks::<LANES>().0;
        for ((out, sum), offset) in out.as_chunks_mut::<LANES>().0.iter_mut().zip(sums).zip(offsets) {
            // SAFETY: both arrays have sixteen f32; unaligned loads and stores take any address.
            unsafe {
                _mm512_storeu_ps(out.as_mut_ptr(), _mm512_add_ps(sum, _mm512_loadu_ps(offset.as_ptr())))
            };
        }
    }
}
