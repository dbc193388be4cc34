//! Masks: logits for each part of the picture.

use crate::layer::{Layer, Rectifier};
use crate::supported::{ArchitectureError, check};

/// Masks read off one of the convolutions: a convolution of 1 x 1 pixels without a rectifier, whose
/// outputs at each pixel are `cells * cells` logits of each mask (depth to space, Shi et al.,
/// "Real-time single image and video super-resolution", 2016).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Masks {
    /// The convolution, counted from 0, whose output they are read from.
    pub convolution: u32,
    /// How many masks.
    pub count: u32,
    /// Pixels a side of a mask that each pixel of that convolution answers for.
    pub cells: u32,
}

impl Masks {
    /// Where the logits of a picture lie: for each run of `cells` values, its start in the outputs
    /// of the layer, `[y][x][mask][cell y][cell x]`, and in the masks, `[mask][y][x]`. `side` is
    /// that of the convolution's output.
    pub fn runs(self, side: usize) -> impl Iterator<Item = (usize, usize)> {
        let (count, cells) = (self.count as usize, self.cells as usize);
        let width = side * cells;
        let pixels = (0..side).flat_map(move |y| (0..side).map(move |x| (y * cells, x * cells)));
        let starts = pixels.flat_map(move |(y, x)| {
            (0..count).flat_map(move |mask| (0..cells).map(move |cell| (mask * width + y + cell) * width + x))
        });
        starts.enumerate().map(move |(run, start)| (run * cells, start))
    }

    /// The layer that computes them from the output of a convolution.
    pub(crate) fn layer(self, convolution: &Layer) -> Layer {
        Layer {
            input_side: convolution.output_side,
            input_planes: convolution.output_planes,
            kernel: 1,
            stride: 1,
            padding: 0,
            output_side: convolution.output_side,
            output_planes: (self.count * self.cells * self.cells) as usize,
            rectifier: Rectifier::None,
        }
    }

    /// Each number by itself, in a network of `convolutions` convolutions.
    pub(crate) fn check(self, convolutions: usize) -> Result<(), ArchitectureError> {
        let [convolution, count, cells] = [self.convolution, self.count, self.cells].map(u64::from);
        check(
            convolution < convolutions as u64,
            convolution,
            "convolution of the masks",
            "those of the network are supported, counted from 0",
        )?;
        check((1..=64).contains(&count), count, "number of masks", "1 to 64 are supported")?;
        check((1..=16).contains(&cells), cells, "number of mask cells a side", "1 to 16 are supported")?;
        let outputs = count * cells * cells;
        check(outputs <= 1024, outputs, "number of mask values a pixel", "at most 1024 are supported")
    }
}
