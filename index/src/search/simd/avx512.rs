//! AVX-512 with VNNI: one register holds four axes of sixteen vectors, and one instruction
//! multiplies them by four values of the query and adds the products up.

use super::{avx2, portable};
use crate::search::blocks::{Block, Blocks, CodeBits, LANES, QuantisedQuery};
use crate::search::distance;
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use std::arch::x86_64::{
    __m256i, __m512, __m512i, _CMP_LE_OQ, _mm256_add_ps, _mm256_castpd_ps, _mm256_loadu_si256,
    _mm512_add_epi32, _mm512_add_ps, _mm512_and_si512, _mm512_castps_pd, _mm512_castps512_ps256,
    _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_cvtph_ps, _mm512_dpbusd_epi32, _mm512_extractf64x4_pd,
    _mm512_loadu_ps, _mm512_loadu_si512, _mm512_maskz_compress_epi32, _mm512_mul_ps, _mm512_set1_epi8,
    _mm512_set1_epi32, _mm512_set1_ps, _mm512_setr_epi32, _mm512_setzero_ps, _mm512_setzero_si512,
    _mm512_slli_epi32, _mm512_srli_epi16, _mm512_storeu_ps, _mm512_storeu_si512, _mm512_sub_epi32,
    _mm512_sub_ps,
};

/// Several blocks go together: they have as many sums as the instruction takes steps, so that none
/// waits for the one before it, and share the query's values.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn scan(run: Blocks<'_>, query: &QuantisedQuery, factor: f32, base: f32, into: &mut [f32]) {
    let query = Query { query, bias: query.bias(run.bits()), factor, base };
    match run.bits() {
        CodeBits::Four => by_twos::<true, true>(run, &query, into),
        // Every entry is such a query while a hash is learned.
        CodeBits::Eight if query.query.is_of_codes => by_twos::<false, false>(run, &query, into),
        CodeBits::Eight => by_twos::<true, false>(run, &query, into),
    }
}

/// What makes scores of codes.
struct Query<'a> {
    query: &'a QuantisedQuery,
    bias: i32,
    factor: f32,
    base: f32,
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn by_twos<const LOW: bool, const HALVES: bool>(run: Blocks<'_>, query: &Query<'_>, into: &mut [f32]) {
    let mut blocks = run.iter().zip(into.as_chunks_mut().0);
    while let Some((first, into)) = blocks.next() {
        match blocks.next() {
            Some((second, next)) => score::<2, LOW, HALVES>([first, second], query, [into, next]),
            None => score::<1, LOW, HALVES>([first], query, [into]),
        }
    }
}

/// `HALVES`: whether a code is half a byte.
///
/// The instruction takes the query's values as signed bytes, so a value goes in as `128 * high +
/// low`, or, of a query whose low bytes are all 0, without `LOW`, as its high half alone.
///
/// Loops in place of `map` and `fold`: their closures belong to functions of the standard library,
/// which are compiled for any processor, and are not inlined into one that is for this.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn score<const N: usize, const LOW: bool, const HALVES: bool>(
    blocks: [Block<'_>; N],
    query: &Query<'_>,
    into: [&mut [f32; LANES]; N],
) {
    let &Query { query, bias, factor, base } = query;
    // Two groups of four axes at a time, a last one by itself. Of codes of half a byte two groups
    // lie in the same bytes, and none is by itself.
    let (high, low) = (query.high.as_chunks::<4>().0, query.low.as_chunks::<4>().0);
    let per_bytes = if HALVES { 2 } else { 1 };
    let mut groups = high.len().min(low.len());
    for block in &blocks {
        groups = groups.min(block.codes.as_chunks::<{ 4 * LANES }>().0.len() * per_bytes);
    }
    let (high, last_high) = high[..groups].as_chunks::<2>();
    let (low, last_low) = low[..groups].as_chunks::<2>();
    let mut codes: [&[[u8; 4 * LANES]]; N] = [&[]; N];
    for (codes, block) in codes.iter_mut().zip(&blocks) {
        *codes = &block.codes.as_chunks().0[..groups / per_bytes];
    }
    let lower = _mm512_set1_epi8(15);
    // The high and the low half of each block's even and odd groups.
    let mut sums = [[[_mm512_setzero_si512(); 2]; 2]; N];
    for (at, (high, low)) in high.iter().zip(low).enumerate() {
        let (high, low) = ([four(high[0]), four(high[1])], [four(low[0]), four(low[1])]);
        for (sums, codes) in sums.iter_mut().zip(&codes) {
            let pair = if HALVES {
                let both = load(&codes[at]);
                [_mm512_and_si512(both, lower), _mm512_and_si512(_mm512_srli_epi16::<4>(both), lower)]
            } else {
                [load(&codes[2 * at]), load(&codes[2 * at + 1])]
            };
            for odd in 0..2 {
                sums[odd][0] = _mm512_dpbusd_epi32(sums[odd][0], pair[odd], high[odd]);
                if LOW {
                    sums[odd][1] = _mm512_dpbusd_epi32(sums[odd][1], pair[odd], low[odd]);
                }
            }
        }
    }
    for (&high, &low) in last_high.iter().zip(last_low) {
        let (high, low) = (four(high), four(low));
        for (sums, codes) in sums.iter_mut().zip(&codes) {
            let Some(codes) = codes.last() else { continue };
            let codes = load(codes);
            sums[0][0] = _mm512_dpbusd_epi32(sums[0][0], codes, high);
            if LOW {
                sums[0][1] = _mm512_dpbusd_epi32(sums[0][1], codes, low);
            }
        }
    }
    let (factor, base) = (_mm512_set1_ps(factor), _mm512_set1_ps(base));
    let bias = _mm512_set1_epi32(bias);
    for ((block, sums), into) in blocks.iter().zip(sums).zip(into) {
        let high = _mm512_slli_epi32::<7>(_mm512_add_epi32(sums[0][0], sums[1][0]));
        let low = _mm512_add_epi32(sums[0][1], sums[1][1]);
        let dots = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_add_epi32(high, low), bias));
        // SAFETY: the scalars are an array of sixteen f32; an unaligned load takes any address.
        let scalars = unsafe { _mm512_loadu_ps(block.scalars.as_ptr()) };
        let scores = _mm512_add_ps(base, _mm512_sub_ps(scalars, _mm512_mul_ps(factor, dots)));
        // SAFETY: the array has room for sixteen f32; an unaligned store takes any address.
        unsafe { _mm512_storeu_ps(into.as_mut_ptr(), scores) };
    }
}

/// Without a branch: which scores are near cannot be foreseen.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn near(scores: &[f32], bound: f32, into: &mut Vec<u32>) {
    let bound = _mm512_set1_ps(bound);
    let mut places = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let mut count = 0;
    into.resize(scores.len(), 0);
    for scores in scores.as_chunks::<LANES>().0 {
        // SAFETY: the scores are an array of sixteen f32; an unaligned load takes any address.
        let scores = unsafe { _mm512_loadu_ps(scores.as_ptr()) };
        let mask = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(scores, bound);
        let near = _mm512_maskz_compress_epi32(mask, places);
        // There is room for sixteen: before this block there were no more than sixteen for each.
        if let Some(into) = into.get_mut(count..).and_then(|into| into.first_chunk_mut::<LANES>()) {
            // SAFETY: the array has room for sixteen u32; an unaligned store takes any address.
            unsafe { _mm512_storeu_si512(into.as_mut_ptr().cast(), near) };
        }
        count += mask.count_ones() as usize;
        places = _mm512_add_epi32(places, _mm512_set1_epi32(LANES as i32));
    }
    into.truncate(count);
}

/// Four values of a query, for each of sixteen vectors.
#[inline]
#[target_feature(enable = "avx512f")]
fn four(values: [u8; 4]) -> __m512i {
    _mm512_set1_epi32(i32::from_ne_bytes(values))
}

#[inline]
#[target_feature(enable = "avx512f")]
fn load(codes: &[u8; 4 * LANES]) -> __m512i {
    // SAFETY: the array has the register's 64 bytes; an unaligned load takes any address.
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
    sum_up(lanes, rest_a, rest_b)
}

/// As [`distances`], of rows of 16 bits a value: what they widen to is exact.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn distances_of_halves<'a>(
    query: &[f32],
    rows: impl Iterator<Item = &'a [f16]>,
    mut each: impl FnMut(usize, f32),
) {
    for (at, row) in rows.enumerate() {
        let length = query.len().min(row.len());
        let (whole, rest) = query[..length].as_chunks::<LANES>();
        let (whole_row, rest_row) = row[..length].as_chunks::<LANES>();
        let mut lanes = _mm512_setzero_ps();
        for (query, row) in whole.iter().zip(whole_row) {
            // SAFETY: the arrays have sixteen values of 32 and of 16 bits; unaligned loads take any
            // address.
            let (query, row) = unsafe {
                (_mm512_loadu_ps(query.as_ptr()), _mm256_loadu_si256(row.as_ptr().cast::<__m256i>()))
            };
            let step = _mm512_sub_ps(query, _mm512_cvtph_ps(row));
            lanes = _mm512_add_ps(lanes, _mm512_mul_ps(step, step));
        }
        let mut widened = [0.0; LANES];
        let widened = &mut widened[..rest_row.len()];
        rest_row.convert_to_f32_slice(widened);
        each(at, sum_up(lanes, rest, widened));
    }
}

/// The sum of sixteen lanes, and of the squared differences of what is left.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn sum_up(lanes: __m512, a: &[f32], b: &[f32]) -> f32 {
    let upper = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(lanes)));
    avx2::sum_up(_mm256_add_ps(_mm512_castps512_ps256(lanes), upper), a, b)
}

/// As [`portable::project`], to the bit: products and sums are rounded one by one.
#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
pub(super) fn project(matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
    let axes = out.len();
    if axes == 0 || !axes.is_multiple_of(LANES) || offset.len() != axes {
        return portable::project(matrix, offset, vector, out);
    }
    let mut start = 0;
    while start < axes {
        let columns = Columns { matrix, offset, vector, start };
        start += match (axes - start) / LANES {
            8.. => columns.project::<8>(out),
            4.. => columns.project::<4>(out),
            2.. => columns.project::<2>(out),
            _ => columns.project::<1>(out),
        };
    }
}

/// Some columns of a matrix that a vector is multiplied by.
struct Columns<'a> {
    matrix: &'a [f32],
    offset: &'a [f32],
    vector: &'a [f32],
    start: usize,
}

impl Columns<'_> {
    /// Gives `N` times sixteen coordinates, and says how many.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
    fn project<const N: usize>(&self, out: &mut [f32]) -> usize {
        let (axes, columns) = (out.len(), self.start..self.start + N * LANES);
        let mut sums = [_mm512_setzero_ps(); N];
        for (row, &value) in self.matrix.chunks_exact(axes).zip(self.vector) {
            let value = _mm512_set1_ps(value);
            for (sum, row) in sums.iter_mut().zip(row[columns.clone()].as_chunks::<LANES>().0) {
                // SAFETY: the array has sixteen f32; an unaligned load takes any address.
                let row = unsafe { _mm512_loadu_ps(row.as_ptr()) };
                *sum = _mm512_add_ps(*sum, _mm512_mul_ps(value, row));
            }
        }
        let offsets = self.offset[columns.clone()].as_chunks::<LANES>().0;
        let outs = out[columns].as_chunks_mut::<LANES>().0;
        for ((out, sum), offset) in outs.iter_mut().zip(sums).zip(offsets) {
            // SAFETY: both arrays have sixteen f32; unaligned loads and stores take any address.
            unsafe {
                _mm512_storeu_ps(out.as_mut_ptr(), _mm512_add_ps(sum, _mm512_loadu_ps(offset.as_ptr())))
            };
        }
        N * LANES
    }
}
