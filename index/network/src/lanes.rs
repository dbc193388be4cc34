//! Weights that are computed with together.

use crate::layer::{LANES, Stored};
use half::f16;
use half::slice::HalfFloatSliceExt;

/// The weights of one input for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    /// Of no weights.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// Takes as many weights as there are; the others stay as they are.
    pub(crate) fn widen(&mut self, stored: &[Stored]) {
        // Nearly all blocks are whole: nothing of a length that is not known is copied.
        if let Some(stored) = stored.first_chunk::<LANES>() {
            let narrow = stored.map(f16::from_le_bytes);
            return narrow.convert_to_f32_slice(&mut self.0);
        }
        let mut narrow = [f16::ZERO; LANES];
        let (narrow, lanes) = (&mut narrow[..stored.len()], &mut self.0[..stored.len()]);
        narrow.iter_mut().zip(stored).for_each(|(narrow, stored)| *narrow = f16::from_le_bytes(*stored));
        narrow.convert_to_f32_slice(lanes);
    }
}
