//! AVX2. Codes of half a byte are multiplied as bytes, and products are summed in 16 bits for as
//! long as they fit; codes of a byte are widened to 16 bits, so that products of two axes can be
//! added in one instruction without loss.

use super::portable;
use crate::search::blocks::{Block, Blocks, CodeBits, LANES, QuantisedQuery};
use crate::search::distance;
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use std::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_LE_OQ, _mm_add_ps, _mm_add_ss, _mm_cvtss_f32, _mm_loadl_epi64,
    _mm_loadu_ps, _mm_loadu_si128, _mm_movehl_ps, _mm_mul_ps, _mm_setzero_ps, _mm_shuffle_ps, _mm_sub_ps,
    _mm256_add_epi16, _mm256_add_epi32, _mm256_add_ps, _mm256_and_si256, _mm256_broadcastq_epi64,
    _mm256_castps256_ps128, _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvtepu8_epi16, _mm256_cvtepu8_epi32,
    _mm256_cvtph_ps, _mm256_extractf128_ps, _mm256_hadd_epi32, _mm256_loadu_ps, _mm256_loadu_si256,
    _mm256_madd_epi16, _mm256_maddubs_epi16, _mm256_movemask_ps, _mm256_mul_ps, _mm256_permute4x64_epi64,
    _mm256_set1_epi8, _mm256_set1_epi16, _mm256_set1_epi32, _mm256_set1_epi64x, _mm256_set1_ps,
    _mm256_setzero_ps, _mm256_setzero_si256, _mm256_shuffle_epi32, _mm256_srli_epi16, _mm256_storeu_ps,
    _mm256_storeu_si256, _mm256_sub_epi32, _mm256_sub_ps,
};

/// Groups whose products are summed in 16 bits: two pairs of products each, of which one is at most
/// 15 * 128.
const GROUPS_IN_WORDS: usize = 4;
const _: () = assert!(GROUPS_IN_WORDS * 2 * 2 * 15 * 128 <= i16::MAX as usize);

#[target_feature(enable = "avx2,f16c,popcnt")]
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut [f32]) {
    let score = Score { bias: query.bias(run.bits()), factor, base };
    match run.bits() {
        CodeBits::Four => by_twos(run, query, &score, into),
        CodeBits::Eight => {
            for (block, into) in run.iter().zip(into.as_chunks_mut().0) {
                score.put(&block, dots_of_bytes(block.codes, query), into);
            }
        }
    }
}

/// What makes scores of dot products.
struct Score {
    bias: i32,
    factor: f32,
    base: f32,
}

impl Score {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn put(&self, block: &Block<'_>, dots: [__m256i; 2], into: &mut [f32; LANES]) {
        let (factor, base) = (_mm256_set1_ps(self.factor), _mm256_set1_ps(self.base));
        let bias = _mm256_set1_epi32(self.bias);
        let halves = into.as_chunks_mut::<8>().0.iter_mut().zip(block.scalars.as_chunks::<8>().0);
        for ((scores, scalars), dots) in halves.zip(dots) {
            let dots = _mm256_cvtepi32_ps(_mm256_sub_epi32(dots, bias));
            // SAFETY: the scalars are an array of eight f32; an unaligned load takes any address.
            let scalars = unsafe { _mm256_loadu_ps(scalars.as_ptr()) };
            let found = _mm256_add_ps(base, _mm256_sub_ps(scalars, _mm256_mul_ps(factor, dots)));
            // SAFETY: the array has room for eight f32; an unaligned store takes any address.
            unsafe { _mm256_storeu_ps(scores.as_mut_ptr(), found) };
        }
    }
}

/// Two blocks go together, for they share the query's values.
#[inline]
#[target_feature(enable = "avx2")]
fn by_twos(run: Blocks<'_>, query: &QuantisedQuery, score: &Score, into: &mut [f32]) {
    let mut blocks = run.iter().zip(into.as_chunks_mut().0);
    while let Some((first, into)) = blocks.next() {
        match blocks.next() {
            Some((second, next)) => {
                let [dots, next_dots] = dots_of_halves([first.codes, second.codes], query);
                score.put(&first, dots, into);
                score.put(&second, next_dots, next);
            }
            None => {
                let [dots] = dots_of_halves([first.codes], query);
                score.put(&first, dots, into);
            }
        }
    }
}

/// Dot products of the sixteen vectors of each block, whose codes are half a byte: as in AVX-512,
/// by the high and the low bytes of the query's values.
#[inline]
#[target_feature(enable = "avx2")]
fn dots_of_halves<const N: usize>(blocks: [&[u8]; N], query: &QuantisedQuery) -> [[__m256i; 2]; N] {
    let lower = _mm256_set1_epi8(15);
    let (high_unit, low_unit) = (_mm256_set1_epi16(128), _mm256_set1_epi16(1));
    let (high, low) = (query.high.as_chunks::<8>().0, query.low.as_chunks::<8>().0);
    let mut groups = high.len().min(low.len());
    for codes in &blocks {
        groups = groups.min(codes.as_chunks::<{ 4 * LANES }>().0.len());
    }
    // The first eight vectors, and the others.
    let mut dots = [[_mm256_setzero_si256(); 2]; N];
    for start in (0..groups).step_by(GROUPS_IN_WORDS) {
        // Of each vector the sums of its first two and of its last two axes of four.
        let (mut of_high, mut of_low) = ([[_mm256_setzero_si256(); 2]; N], [[_mm256_setzero_si256(); 2]; N]);
        for group in start..groups.min(start + GROUPS_IN_WORDS) {
            let (high, low) = (fours(&high[group]), fours(&low[group]));
            for block in 0..N {
                let codes = &blocks[block].as_chunks::<{ 4 * LANES }>().0[group];
                for (half, codes) in codes.as_chunks::<32>().0.iter().enumerate() {
                    let codes = load(codes);
                    let upper = _mm256_and_si256(_mm256_srli_epi16::<4>(codes), lower);
                    let codes = [_mm256_and_si256(codes, lower), upper];
                    for odd in 0..2 {
                        let products = _mm256_maddubs_epi16(codes[odd], high[odd]);
                        of_high[block][half] = _mm256_add_epi16(of_high[block][half], products);
                        let products = _mm256_maddubs_epi16(codes[odd], low[odd]);
                        of_low[block][half] = _mm256_add_epi16(of_low[block][half], products);
                    }
                }
            }
        }
        for block in 0..N {
            for half in 0..2 {
                let high = _mm256_madd_epi16(of_high[block][half], high_unit);
                let low = _mm256_madd_epi16(of_low[block][half], low_unit);
                dots[block][half] = _mm256_add_epi32(dots[block][half], _mm256_add_epi32(high, low));
            }
        }
    }
    dots
}

/// The same of codes that are bytes.
#[inline]
#[target_feature(enable = "avx2")]
fn dots_of_bytes(codes: &[u8], query: &QuantisedQuery) -> [__m256i; 2] {
    // Each register holds four vectors, two sums of two axes each.
    let mut sums = [_mm256_setzero_si256(); 4];
    for (codes, &four) in codes.as_chunks::<{ 4 * LANES }>().0.iter().zip(query.values.as_chunks::<4>().0) {
        let values = _mm256_set1_epi64x(bytemuck::cast(four));
        for (sum, codes) in sums.iter_mut().zip(codes.as_chunks::<16>().0) {
            // SAFETY: the array has the register's 16 bytes; an unaligned load takes any address.
            let codes = unsafe { _mm_loadu_si128(codes.as_ptr().cast::<__m128i>()) };
            *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(_mm256_cvtepu8_epi16(codes), values));
        }
    }
    // Adding neighbours leaves vectors 0 1 4 5 2 3 6 7: put them in order.
    let [first, second, third, fourth] = sums;
    [[first, second], [third, fourth]]
        .map(|[low, high]| _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_hadd_epi32(low, high)))
}

/// Twice four values of a query, for each of eight vectors.
#[inline]
#[target_feature(enable = "avx2")]
fn fours(values: &[u8; 8]) -> [__m256i; 2] {
    // SAFETY: the array has the eight bytes that are read; an unaligned load takes any address.
    let values = unsafe { _mm_loadl_epi64(values.as_ptr().cast::<__m128i>()) };
    let values = _mm256_broadcastq_epi64(values);
    [_mm256_shuffle_epi32::<0>(values), _mm256_shuffle_epi32::<0b01_01_01_01>(values)]
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(codes: &[u8; 32]) -> __m256i {
    // SAFETY: the array has the register's 32 bytes; an unaligned load takes any address.
    unsafe { _mm256_loadu_si256(codes.as_ptr().cast::<__m256i>()) }
}

/// Without a branch: which scores are near cannot be foreseen.
#[target_feature(enable = "avx2,f16c,popcnt")]
pub(super) fn near(scores: &[f32], bound: f32, into: &mut Vec<u32>) {
    let bound = _mm256_set1_ps(bound);
    let mut count = 0;
    into.resize(scores.len(), 0);
    for (start, scores) in (0i32..).step_by(8).zip(scores.as_chunks::<8>().0) {
        // SAFETY: the scores are an array of eight f32; an unaligned load takes any address.
        let scores = unsafe { _mm256_loadu_ps(scores.as_ptr()) };
        let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(scores, bound)) as u8;
        let lanes = &SET_BITS[usize::from(mask)];
        // There is room for eight: before these there were no more than eight for each.
        if let Some(into) = into.get_mut(count..).and_then(|into| into.first_chunk_mut::<8>()) {
            // SAFETY: the array has eight bytes, which the load reads; an unaligned store takes any
            // address, and has room for eight u32.
            unsafe {
                let lanes = _mm256_cvtepu8_epi32(_mm_loadl_epi64(lanes.as_ptr().cast::<__m128i>()));
                let near = _mm256_add_epi32(lanes, _mm256_set1_epi32(start));
                _mm256_storeu_si256(into.as_mut_ptr().cast::<__m256i>(), near);
            }
        }
        count += mask.count_ones() as usize;
    }
    into.truncate(count);
}

/// Of each byte, which of its bits are set, in order, and zeros.
static SET_BITS: [[u8; 8]; 256] = {
    let mut all = [[0; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                all[byte][count] = bit;
                count += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    all
};

#[target_feature(enable = "avx2,f16c,popcnt")]
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

/// As [`distances`], of rows of 16 bits a value: what they widen to is exact.
#[target_feature(enable = "avx2,f16c,popcnt")]
pub(super) fn distances_of_halves<'a>(
    query: &[f32],
    rows: impl Iterator<Item = &'a [f16]>,
    mut each: impl FnMut(usize, f32),
) {
    for (at, row) in rows.enumerate() {
        let length = query.len().min(row.len());
        let (whole, rest) = query[..length].as_chunks::<LANES>();
        let (whole_row, rest_row) = row[..length].as_chunks::<LANES>();
        let mut lanes = [_mm256_setzero_ps(); 2];
        for (query, row) in whole.iter().zip(whole_row) {
            let eights = query.as_chunks::<8>().0.iter().zip(row.as_chunks::<8>().0);
            for (sum, (query, row)) in lanes.iter_mut().zip(eights) {
                // SAFETY: the arrays have eight values of 32 and of 16 bits; unaligned loads take
                // any address.
                let (query, row) = unsafe {
                    (_mm256_loadu_ps(query.as_ptr()), _mm_loadu_si128(row.as_ptr().cast::<__m128i>()))
                };
                let step = _mm256_sub_ps(query, _mm256_cvtph_ps(row));
                *sum = _mm256_add_ps(*sum, _mm256_mul_ps(step, step));
            }
        }
        let mut widened = [0.0; LANES];
        let widened = &mut widened[..rest_row.len()];
        rest_row.convert_to_f32_slice(widened);
        each(at, sum_up(_mm256_add_ps(lanes[0], lanes[1]), rest, widened));
    }
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

#[target_feature(enable = "avx2,f16c,popcnt")]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    portable::project(matrix, offset, vector, out);
}
