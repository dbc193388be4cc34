//! The inner loops of a search, for the widest vector registers that the machine has.
//!
//! Whatever the path, the answers are the same to the last bit: dot products of codes are integers,
//! and all floating-point work is done in one order without fused multiply-adds.
//!
//! `unsafe` stands in the two files of intrinsics and in the calls below, which are sound because
//! [`Simd::best`] and [`Simd::available`] are the only ways to get a value other than
//! [`Level::Portable`], and both ask the processor first.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;

use super::blocks::{Blocks, QuantisedQuery};
use half::f16;
use half::slice::HalfFloatSliceExt as _;

/// Which instructions are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Simd(Level);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// AVX-512 with VNNI: sixteen vectors, four axes at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// AVX2, and what else its processors have: F16C and POPCNT.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Vectors of the crate `wide` and what the compiler makes of plain loops; on aarch64 both are
    /// NEON.
    Portable,
}

impl Simd {
    /// The fastest that this machine has.
    pub(crate) fn best() -> Self {
        Self::available()[0]
    }

    /// All that this machine has, fastest first.
    pub(crate) fn available() -> Vec<Self> {
        let mut levels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vnni")
            {
                levels.push(Self(Level::Avx512));
            }
            if is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("f16c")
                && is_x86_feature_detected!("popcnt")
            {
                levels.push(Self(Level::Avx2));
            }
        }
        levels.push(Self(Level::Portable));
        levels
    }

    /// A name for people.
    pub(crate) fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "AVX-512 VNNI",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "AVX2",
            Level::Portable => "portable",
        }
    }

    /// Puts the score of every place of `run` into `into`, which has as many: `base + (scalar -
    /// factor * <codes, query>)`, infinity where there is no vector.
    pub(crate) fn scan(
        self,
        run: Blocks<'_>,
        query: &QuantisedQuery,
        factor: f32,
        base: f32,
        into: &mut [f32],
    ) {
        match self.0 {
            // SAFETY: the level says that the processor has the instructions; `Self::available`
            // asked it.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::scan(run, query, factor, base, into) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::scan(run, query, factor, base, into) },
            Level::Portable => portable::scan(run, query, factor, base, into),
        }
    }

    /// Puts the places of those `scores` that are not above `bound` into `into`, in order. The
    /// number of scores is a multiple of sixteen, as blocks have.
    pub(crate) fn near(self, scores: &[f32], bound: f32, into: &mut Vec<u32>) {
        match self.0 {
            // SAFETY: the level says that the processor has the instructions; `Self::available`
            // asked it.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::near(scores, bound, into) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::near(scores, bound, into) },
            Level::Portable => portable::near(scores, bound, into),
        }
    }

    /// The squared distance of `query` from each of `rows`:
    /// [`super::distance::squared`], to the bit.
    pub(crate) fn distances<'a>(
        self,
        query: &[f32],
        rows: impl Iterator<Item = &'a [f32]>,
        each: impl FnMut(usize, f32),
    ) {
        match self.0 {
            // SAFETY: the level says that the processor has the instructions; `Self::available`
            // asked it.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::distances(query, rows, each) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::distances(query, rows, each) },
            Level::Portable => portable::distances(query, rows, each),
        }
    }

    /// As [`Self::distances`], of rows of 16 bits a value; `row` is where they are widened where the
    /// processor does not do so on its way.
    pub(crate) fn distances_of_halves<'a>(
        self,
        query: &[f32],
        rows: impl Iterator<Item = &'a [f16]>,
        row: &mut Vec<f32>,
        mut each: impl FnMut(usize, f32),
    ) {
        #[cfg(target_arch = "x86_64")]
        match self.0 {
            // SAFETY: as above.
            Level::Avx512 => return unsafe { avx512::distances_of_halves(query, rows, each) },
            // SAFETY: as above.
            Level::Avx2 => return unsafe { avx2::distances_of_halves(query, rows, each) },
            Level::Portable => {}
        }
        for (at, halves) in rows.enumerate() {
            row.resize(halves.len(), 0.0);
            halves.convert_to_f32_slice(row);
            self.distances(query, [&row[..]].into_iter(), |_, squared| each(at, squared));
        }
    }

    /// `out = offset + vector * matrix`: see [`portable::project`].
    pub(crate) fn project(self, matrix: &[f32], offset: &[f32], vector: &[f32], out: &mut [f32]) {
        match self.0 {
            // SAFETY: the level says that the processor has the instructions; `Self::available`
            // asked it.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { avx512::project(matrix, offset, vector, out) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { avx2::project(matrix, offset, vector, out) },
            Level::Portable => portable::project(matrix, offset, vector, out),
        }
    }
}

/// Asks the processor to fetch the cache lines that hold `bytes`; of no effect besides time.
#[inline]
pub(crate) fn prefetch_all(bytes: &[u8]) {
    #[cfg(target_arch = "x86_64")]
    for line in bytes.chunks(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch reads nothing that a program could see, and the address is that of a
        // byte of the slice.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = bytes;
}

#[cfg(test)]
mod tests;
