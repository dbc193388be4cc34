//! A dense layer with a bias and nothing after it: the heads, and the masks at each pixel.

use crate::dense::{self, DenseShape};
use crate::matrix::Before;
use std::ops::Range;

/// Where the parameters of such a layer lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Affine {
    pub(crate) shape: DenseShape,
    /// `[inputs][outputs]`, in the parameters.
    pub(crate) matrix: Range<usize>,
    /// `[outputs]`, in the parameters.
    pub(crate) bias: Range<usize>,
}

impl Affine {
    /// Computes the outputs of each row of `inputs`.
    pub(crate) fn forward(&self, parameters: &[f32], inputs: &[f32], outputs: &mut Vec<f32>) {
        outputs.resize(inputs.len() / self.shape.inputs * self.shape.outputs, 0.0);
        dense::forward(self.shape, &parameters[self.matrix.clone()], inputs, outputs);
        let bias = &parameters[self.bias.clone()];
        for outputs in outputs.chunks_exact_mut(self.shape.outputs) {
            outputs.iter_mut().zip(bias).for_each(|(output, bias)| *output += bias);
        }
    }

    /// Writes the gradients with respect to the matrix and the bias.
    pub(crate) fn parameter_gradients(&self, inputs: &[f32], of_outputs: &[f32], gradients: &mut [f32]) {
        let bias = &mut gradients[self.bias.clone()];
        bias.fill(0.0);
        for row in of_outputs.chunks_exact(self.shape.outputs) {
            bias.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        dense::matrix_gradient(self.shape, inputs, of_outputs, &mut gradients[self.matrix.clone()]);
    }

    /// Writes or adds the gradient with respect to the inputs.
    pub(crate) fn input_gradients(
        &self,
        parameters: &[f32],
        of_outputs: &[f32],
        before: Before,
        of_inputs: &mut [f32],
    ) {
        dense::input_gradients(self.shape, &parameters[self.matrix.clone()], of_outputs, before, of_inputs);
    }
}
