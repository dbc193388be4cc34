//! The network's shape, and what shapes are supported.

use crate::layer::{Layer, Rectifier};
use crate::masks::Masks;
use crate::supported::{ArchitectureError, check};

/// One convolution with its bias, followed by a rectifier. Borders are padded with `kernel / 2`
/// zeros, so that a stride of 1 keeps the size and a stride of 2 halves an even one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Convolution {
    /// Pixels a side, odd.
    pub kernel: u32,
    /// Input pixels a step: 1 or 2.
    pub stride: u32,
    /// Output planes.
    pub outputs: u32,
}

/// The network's layers, from the input to the heads and the masks.
///
/// A picture of `side * side * planes` values (row by row, the planes of a pixel together) passes
/// the convolutions; all values of the last one become the embedding by a dense layer and a leaky
/// rectifier of slope [`Self::LEAK`]; the heads are a dense layer on the embedding. [`Masks`] are
/// read off one of the convolutions.
///
/// The weights are one array, layer by layer: a convolution's kernel `[y][x][input][output]`, then
/// its bias `[output]`; the embedding's matrix `[input][output]` (inputs row by row, the planes of
/// a pixel together) and bias; the heads' matrix `[input][output]` and bias; last the masks' matrix
/// `[input][output]` and bias, their outputs in the order `[mask][y][x]` of a pixel's cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Architecture {
    /// Pixels a side of the input.
    pub side: u32,
    /// Planes of the input.
    pub planes: u32,
    /// The convolutions in their order.
    pub convolutions: Vec<Convolution>,
    /// Values of the embedding.
    pub embedding: u32,
    /// Values of all heads together.
    pub heads: u32,
    /// The masks, where there are any.
    pub masks: Option<Masks>,
}

impl Architecture {
    /// The slope of the embedding's rectifier below 0.
    pub const LEAK: f32 = 0.25;

    /// Checks that a network of this shape takes bounded memory and time, so that a file that asks
    /// for more is rejected before anything is allocated.
    ///
    /// # Errors
    /// Names the first number that is out of range.
    pub fn validate(&self) -> Result<(), ArchitectureError> {
        self.layers().map(|_| ())
    }

    /// The layers with their sizes, in the order of their weights: each convolution, the embedding,
    /// the heads, and the masks where there are any.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn layers(&self) -> Result<Vec<Layer>, ArchitectureError> {
        self.check_ranges()?;
        let mut layers = Vec::with_capacity(self.convolutions.len() + 3);
        let (mut side, mut planes) = (self.side as usize, self.planes as usize);
        for convolution in &self.convolutions {
            let stride = convolution.stride as usize;
            let layer = Layer {
                input_side: side,
                input_planes: planes,
                kernel: convolution.kernel as usize,
                stride,
                padding: convolution.kernel as usize / 2,
                output_side: side.div_ceil(stride),
                output_planes: convolution.outputs as usize,
                rectifier: Rectifier::Zero,
            };
            (side, planes) = (layer.output_side, layer.output_planes);
            layers.push(layer);
        }
        layers.push(Layer::dense(side, planes, self.embedding as usize, Rectifier::Leaky));
        layers.push(Layer::dense(1, self.embedding as usize, self.heads as usize, Rectifier::None));
        if let Some(masks) = self.masks {
            let read = layers.get(masks.convolution as usize).map(|layer| masks.layer(layer));
            layers.extend(read);
        }
        check_totals(&layers)?;
        Ok(layers)
    }

    /// Pixels a side of the masks; 0 without any.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn mask_side(&self) -> Result<usize, ArchitectureError> {
        let layers = self.layers()?;
        let side = |masks: Masks| {
            let read = layers.get(masks.convolution as usize);
            read.map_or(0, |layer| layer.output_side * masks.cells as usize)
        };
        Ok(self.masks.map_or(0, side))
    }

    /// The layer whose output layer `at` reads; none reads the picture.
    pub(crate) fn source(&self, at: usize) -> Option<usize> {
        match self.masks {
            Some(masks) if at == self.convolutions.len() + 2 => Some(masks.convolution as usize),
            _ => at.checked_sub(1),
        }
    }

    /// Weights and biases of all layers: the length of the array that
    /// [`crate::Network::from_weights`] takes.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn parameters(&self) -> Result<usize, ArchitectureError> {
        Ok(self.layers()?.iter().map(Layer::parameters).sum())
    }

    /// The number of convolutions, before they are read.
    pub(crate) fn check_convolutions(count: usize) -> Result<(), ArchitectureError> {
        check(count <= 16, count as u64, "number of convolutions", "0 to 16 are supported")
    }

    /// Each number by itself.
    fn check_ranges(&self) -> Result<(), ArchitectureError> {
        let planes = |value: u32, what| {
            check((1..=1024).contains(&value), u64::from(value), what, "1 to 1024 are supported")
        };
        let side = u64::from(self.side);
        check((1..=256).contains(&side), side, "side", "1 to 256 pixels are supported")?;
        planes(self.planes, "number of input planes")?;
        planes(self.embedding, "size of the embedding")?;
        planes(self.heads, "size of the heads")?;
        Self::check_convolutions(self.convolutions.len())?;
        for convolution in &self.convolutions {
            let (kernel, stride) = (u64::from(convolution.kernel), u64::from(convolution.stride));
            let is_odd = kernel % 2 == 1;
            check(is_odd && kernel <= 15, kernel, "kernel", "odd sizes to 15 pixels are supported")?;
            check(matches!(stride, 1 | 2), stride, "stride", "1 and 2 are supported")?;
            planes(convolution.outputs, "number of output planes")?;
        }
        self.masks.map_or(Ok(()), |masks| masks.check(self.convolutions.len()))
    }
}

/// All layers together. The ranges have been checked, so that nothing here overflows.
fn check_totals(layers: &[Layer]) -> Result<(), ArchitectureError> {
    let (mut weights, mut multiply_adds) = (0, 0);
    for layer in layers {
        let values = layer.input_values().max(layer.output_values()) as u64;
        check(values <= 1 << 20, values, "number of activations", "at most 1048576 a layer are supported")?;
        weights += layer.padded_parameters() as u64;
        multiply_adds += layer.padded_multiply_adds();
    }
    check(
        weights <= 8 << 20,
        weights,
        "number of weights",
        "at most 8388608 are supported (with outputs in multiples of 32)",
    )?;
    check(
        multiply_adds <= 1 << 30,
        multiply_adds,
        "number of multiply-adds",
        "at most 1073741824 are supported (with outputs in multiples of 32)",
    )
}
