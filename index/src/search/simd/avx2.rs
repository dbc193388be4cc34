//! AVX2: codes are widened to 16 bits, so that products of two axes can be added in one instruction without loss.

use super::portable;
use crate::search::blocks::{Blocks, LANES, QuantisedQuery};
use crate::search::smallest::Smallest;
use std::arch::x86_64::{
    __m128i, _CMP_LE_OQ, _mm_loadu_si128, _mm256_add_epi32, _mm256_add_ps, _mm256_cmp_ps, _mm256_cvtepi32_ps,
    _mm256_cvtepu8_epi16, _mm256_hadd_epi32, _mm256_loadu_ps, _mm256_madd_epi16, _mm256_movemask_ps,
    _mm256_mul_ps, _mm256_permute4x64_epi64, _mm256_set1_epi32, _mm256_set1_epi64x, _mm256_set1_ps,
    _mm256_setzero_si256, _mm256_storeu_ps, _mm256_sub_epi32, _mm256_sub_ps,
};

#[target_feature(enable = "avx2")]
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut Smallest) {
    let (factor, base) = (_mm256_set1_ps(factor), _mm256_set1_ps(base));
    let bias = _mm256_set1_epi32(query.bias);
    for block in run.iter() {
        // Each register holds four vectors, two sums of two axes each.
        let mut sums = [_mm256_setzero_si256(); 4];
        let groups = block.codes.as_chunks::<{ 4 * LANES }>().0.iter().zip(&query.quads);
        for (codes, &quad) in groups {
            let values = _mm256_set1_epi64x(quad);
            for (sum, codes) in sums.iter_mut().zip(codes.as_chunks::<16>().0) {
                *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(_mm256_cvtepu8_epi16(load(codes)), values));
            }
        }
        let bound = _mm256_set1_ps(into.bound());
        let (mut out, mut mask, mut shift) = ([0.0f32; LANES], 0, 0);
        let halves = out.as_chunks_mut::<8>().0.iter_mut().zip(block.scalars.as_chunks::<8>().0);
        for ((out, scalars), pair) in halves.zip(sums.as_chunks::<2>().0) {
            // Adding neighbours leaves vectors 0 1 4 5 2 3 6 7: put them in order.
            let dots = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_hadd_epi32(pair[0], pair[1]));
            let dots = _mm256_sub_epi32(dots, bias);
            // SAFETY: the scalars are an array of eight f32; an unaligned load takes any address.
            let scalars = unsafe { _mm256_loadu_ps(scalars.as_ptr()) };
            let found =
                _mm256_add_ps(base, _mm256_sub_ps(scalars, _mm256_mul_ps(factor, _mm256_cvtepi32_ps(dots))));
            mask |= (_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(found, bound)) as u16) << shift;
            shift += 8;
            // SAFETY: the array has room for eight f32; an unaligned store takes any address.
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), found) };
        }
        into.offer(&block, &out, mask);
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(codes: &[u8; 16]) -> __m128i {
    // SAFETY: the array has the register's 16 bytes; an unaligned load takes any address.
    unsafe { _mm_loadu_si128(codes.as_ptr().cast::<__m128i>()) }
}

#[target_feature(enable = "avx2")]
pub(super) fn distances<'a>(
    query: &[f32],
    rows: impl Iterator<Item = &'a [f32]>,
    each: impl FnMut(usize, f32),
) {
    portable::distances(query, rows, each);
}

#[target_feature(enable = "avx2")]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    portable::project(matrix, offset, vector, out);
}
