//! AVX2: codes are widened to 16 bits, so that products of two axes can be added in one instruction
//! without loss.

use super::portable;
use crate::search::blocks::{Blocks, CodeBits, LANES, QuantisedQuery};
use crate::search::distance;
use std::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_LE_OQ, _mm_add_ps, _mm_add_ss, _mm_and_si128, _mm_cvtss_f32, _mm_loadu_ps,
    _mm_loadu_si128, _mm_movehl_ps, _mm_mul_ps, _mm_set1_epi8, _mm_setzero_ps, _mm_shuffle_ps,
    _mm_srli_epi16, _mm_sub_ps, _mm256_add_epi32, _mm256_add_ps, _mm256_castps256_ps128, _mm256_cmp_ps,
    _mm256_cvtepi32_ps, _mm256_cvtepu8_epi16, _mm256_extractf128_ps, _mm256_hadd_epi32, _mm256_loadu_ps,
    _mm256_madd_epi16, _mm256_movemask_ps, _mm256_mul_ps, _mm256_permute4x64_epi64, _mm256_set1_epi32,
    _mm256_set1_epi64x, _mm256_set1_ps, _mm256_setzero_ps, _mm256_setzero_si256, _mm256_storeu_ps,
    _mm256_sub_epi32, _mm256_sub_ps,
};

#[target_feature(enable = "avx2")]
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut [f32]) {
    let (factor, base) = (_mm256_set1_ps(factor), _mm256_set1_ps(base));
    let bias = _mm256_set1_epi32(query.bias(run.bits()));
    for (block, into) in run.iter().zip(into.as_chunks_mut::<LANES>().0) {
        // Each register holds four vectors, two sums of two axes each.
        let mut sums = [_mm256_setzero_si256(); 4];
        let groups = block.codes.as_chunks::<{ 4 * LANES }>().0.iter();
        let values = query.values.as_chunks::<4>().0;
        match run.bits() {
            CodeBits::Four => {
                let lower = _mm_set1_epi8(15);
                for (codes, &[low, high]) in groups.zip(values.as_chunks::<2>().0) {
                    for (sum, codes) in sums.iter_mut().zip(codes.as_chunks::<16>().0) {
                        let codes = load(codes);
                        let upper = _mm_srli_epi16::<4>(codes);
                        *sum = add_products(*sum, _mm_and_si128(codes, lower), low);
                        *sum = add_products(*sum, _mm_and_si128(upper, lower), high);
                    }
                }
            }
            CodeBits::Eight => {
                for (codes, &four) in groups.zip(values) {
                    for (sum, codes) in sums.iter_mut().zip(codes.as_chunks::<16>().0) {
                        *sum = add_products(*sum, load(codes), four);
                    }
                }
            }
        }
        let halves = into.as_chunks_mut::<8>().0.iter_mut().zip(block.scalars.as_chunks::<8>().0);
        for ((scores, scalars), pair) in halves.zip(sums.as_chunks::<2>().0) {
            // Adding neighbours leaves vectors 0 1 4 5 2 3 6 7: put them in order.
            let dots = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_hadd_epi32(pair[0], pair[1]));
            let dots = _mm256_cvtepi32_ps(_mm256_sub_epi32(dots, bias));
            // SAFETY: the scalars are an array of eight f32; an unaligned load takes any address.
            let scalars = unsafe { _mm256_loadu_ps(scalars.as_ptr()) };
            let found = _mm256_add_ps(base, _mm256_sub_ps(scalars, _mm256_mul_ps(factor, dots)));
            // SAFETY: the array has room for eight f32; an unaligned store takes any address.
            unsafe { _mm256_storeu_ps(scores.as_mut_ptr(), found) };
        }
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn near(scores: &[f32], bound: f32, into: &mut Vec<u32>) {
    let bound = _mm256_set1_ps(bound);
    into.clear();
    for (start, scores) in (0u32..).step_by(8).zip(scores.as_chunks::<8>().0) {
        // SAFETY: the scores are an array of eight f32; an unaligned load takes any address.
        let scores = unsafe { _mm256_loadu_ps(scores.as_ptr()) };
        let mut mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(scores, bound)) as u8;
        while mask != 0 {
            into.push(start + mask.trailing_zeros());
            mask &= mask - 1;
        }
    }
}

/// Adds the products of four axes of four vectors and the query's four values.
#[inline]
#[target_feature(enable = "avx2")]
fn add_products(sums: __m256i, codes: __m128i, values: [i16; 4]) -> __m256i {
    let values = _mm256_set1_epi64x(bytemuck::cast(values));
    _mm256_add_epi32(sums, _mm256_madd_epi16(_mm256_cvtepu8_epi16(codes), values))
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
    mut each: impl FnMut(usize, f32),
) {
    for (at, row) in rows.enumerate() {
        each(at, squared(query, row));
    }
}

/// As [`distance::squared`], to the bit: differences, products and sums are rounded one by one, and
/// added in its order.
#[inline]
#[target_feature(enable = "avx2")]
fn squared(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = distance::alike(a, b);
    let ((whole_a, rest_a), (whole_b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [_mm256_setzero_ps(); 2];
    for (a, b) in whole_a.iter().zip(whole_b) {
        let eights = a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0);
        for (sum, (a, b)) in lanes.iter_mut().zip(eights) {
            // SAFETY: both arrays have eight f32; an unaligned load takes any address.
            let step = unsafe { _mm256_sub_ps(_mm256_loadu_ps(a.as_ptr()), _mm256_loadu_ps(b.as_ptr())) };
            *sum = _mm256_add_ps(*sum, _mm256_mul_ps(step, step));
        }
    }
    sum_up(_mm256_add_ps(lanes[0], lanes[1]), rest_a, rest_b)
}

/// The sum of eight lanes, and of the squared differences of what is left, fewer than sixteen
/// values.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn sum_up(eight: __m256, a: &[f32], b: &[f32]) -> f32 {
    let ((fours_a, rest_a), (fours_b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut four = _mm_setzero_ps();
    for (a, b) in fours_a.iter().zip(fours_b) {
        // SAFETY: both arrays have four f32; an unaligned load takes any address.
        let step = unsafe { _mm_sub_ps(_mm_loadu_ps(a.as_ptr()), _mm_loadu_ps(b.as_ptr())) };
        four = _mm_add_ps(four, _mm_mul_ps(step, step));
    }
    let tail: f32 = rest_a.iter().zip(rest_b).map(|(&a, &b)| (a - b) * (a - b)).sum();
    let halves = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
    let four = _mm_add_ps(halves, four);
    // Values 0 + 2 and 1 + 3.
    let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two))) + tail
}

#[target_feature(enable = "avx2")]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    portable::project(matrix, offset, vector, out);
}
