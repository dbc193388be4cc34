//! The sizes of one layer. A dense layer is a convolution whose kernel covers its input.

/// Outputs that are computed together.
pub(crate) const LANES: usize = 32;

/// A weight or a bias as a file has it: `f16`, little-endian.
pub(crate) type Stored = [u8; 2];

/// What follows a layer's sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rectifier {
    /// What is not above 0 becomes 0.
    Zero,
    /// What is not above 0 is multiplied by [`crate::Architecture::LEAK`].
    Leaky,
    /// The sums are the output.
    None,
}

/// The sizes of one layer. Its parameters are a matrix `[y][x][input][output]` and a bias
/// `[output]`; a dense layer has a kernel of `input_side` pixels and no padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Pixels a side of the input.
    pub input_side: usize,
    /// Values a pixel of the input.
    pub input_planes: usize,
    /// Pixels a side of the kernel.
    pub kernel: usize,
    /// Input pixels a step.
    pub stride: usize,
    /// Pixels of zeros on each side of the input.
    pub padding: usize,
    /// Pixels a side of the output.
    pub output_side: usize,
    /// Values a pixel of the output.
    pub output_planes: usize,
    /// What follows the sums.
    pub rectifier: Rectifier,
}

impl Layer {
    /// A dense layer from all values of a picture to `outputs` values.
    pub(crate) fn dense(side: usize, planes: usize, outputs: usize, rectifier: Rectifier) -> Self {
        Self {
            input_side: side,
            input_planes: planes,
            kernel: side,
            stride: 1,
            padding: 0,
            output_side: 1,
            output_planes: outputs,
            rectifier,
        }
    }

    /// Inputs of one output, those of the padding included.
    pub fn inputs(&self) -> usize {
        self.kernel * self.kernel * self.input_planes
    }

    /// Weights and biases.
    pub fn parameters(&self) -> usize {
        (self.inputs() + 1) * self.output_planes
    }

    /// Values of the input, without padding.
    pub fn input_values(&self) -> usize {
        self.input_side * self.input_side * self.input_planes
    }

    /// Values of the output.
    pub fn output_values(&self) -> usize {
        self.output_side * self.output_side * self.output_planes
    }

    /// Multiply-adds a picture.
    pub fn multiply_adds(&self) -> u64 {
        self.inputs() as u64 * self.output_values() as u64
    }

    /// Pixels a side of the input with its padding.
    pub(crate) fn padded_side(&self) -> usize {
        self.input_side + 2 * self.padding
    }

    /// Values of the input with its padding.
    pub(crate) fn padded_values(&self) -> usize {
        self.padded_side() * self.padded_side() * self.input_planes
    }

    /// [`Self::parameters`] with the outputs that fill the last block.
    pub(crate) fn padded_parameters(&self) -> usize {
        (self.inputs() + 1) * self.output_planes.next_multiple_of(LANES)
    }

    /// [`Self::multiply_adds`] with the outputs that fill the last block.
    pub(crate) fn padded_multiply_adds(&self) -> u64 {
        let outputs = self.output_side * self.output_side * self.output_planes.next_multiple_of(LANES);
        self.inputs() as u64 * outputs as u64
    }
}
