//! The instructions that the inner loops are compiled for, chosen when the program runs.

use crate::kernel::compute;
use crate::packed::Packed;

/// Which instructions compute a network. The results are the same to the last bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Path(Level);

/// The instructions, of which only [`Path::available`] makes a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    /// AVX-512 with instructions that sum products of bytes.
    #[cfg(target_arch = "x86_64")]
    Avx512Vnni,
    /// AVX-512: vectors of 16 values, 32 registers.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// AVX2 with instructions that sum products of bytes.
    #[cfg(target_arch = "x86_64")]
    AvxVnni,
    /// AVX2: vectors of 8 values, 16 registers.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// What every processor of the target has: SSE2 on x86-64, NEON on aarch64.
    Portable,
}

impl Path {
    /// The fastest that this machine has.
    pub fn best() -> Self {
        Self::available()[0]
    }

    /// All that this machine has, fastest first.
    pub fn available() -> Vec<Self> {
        let mut levels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let has_avx512 = is_x86_feature_detected!("avx512f");
            let has_avx2 = is_x86_feature_detected!("avx2");
            let found = [
                (has_avx512 && is_x86_feature_detected!("avx512vnni"), Level::Avx512Vnni),
                (has_avx512, Level::Avx512),
                (has_avx2 && is_x86_feature_detected!("avxvnni"), Level::AvxVnni),
                (has_avx2, Level::Avx2),
            ];
            levels.extend(found.into_iter().filter(|(is_there, _)| *is_there).map(|(_, level)| Self(level)));
        }
        levels.push(Self(Level::Portable));
        levels
    }

    /// What the instructions are.
    pub(crate) fn level(self) -> Level {
        self.0
    }

    /// A name for people.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512Vnni => "AVX-512 VNNI",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Level::AvxVnni => "AVX-VNNI",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "AVX2",
            Level::Portable => "portable",
        }
    }

    /// Computes a layer; see [`compute`].
    pub(crate) fn compute(self, layer: &Packed, input: &[f32], output: &mut [f32]) {
        match self.0 {
            // SAFETY: the level says that the processor has the instructions: only
            // `Self::available`, which asked it, makes one.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512Vnni | Level::Avx512 => unsafe { avx512(layer, input, output) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::AvxVnni | Level::Avx2 => unsafe { avx2(layer, input, output) },
            Level::Portable => portable(layer, input, output),
        }
    }
}

// The numbers of pixels are the fastest that were measured: 8 registers of sums, and 16 of SSE2 and
// NEON.

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn avx512(layer: &Packed, input: &[f32], output: &mut [f32]) {
    compute::<4>(layer, input, output);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2(layer: &Packed, input: &[f32], output: &mut [f32]) {
    compute::<2>(layer, input, output);
}

fn portable(layer: &Packed, input: &[f32], output: &mut [f32]) {
    compute::<2>(layer, input, output);
}
