//! A dense layer on a whole batch, in pieces that do not depend on the number of threads.

use crate::matrix::{Before, Matrix, multiply};
use rayon::prelude::*;

/// Samples a piece: enough that the packing of the matrix is paid for.
const SAMPLES: usize = 32;
/// Inputs a piece of the matrix's gradient.
const INPUTS: usize = 432;

/// A dense layer's sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DenseShape {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
}

/// `outputs = inputs * matrix`, without a bias.
pub(crate) fn forward(shape: DenseShape, matrix: &[f32], inputs: &[f32], outputs: &mut [f32]) {
    let matrix = Matrix::new(matrix, shape.inputs, shape.outputs);
    let inputs = inputs.par_chunks(SAMPLES * shape.inputs);
    inputs.zip(outputs.par_chunks_mut(SAMPLES * shape.outputs)).for_each(|(inputs, outputs)| {
        let samples = outputs.len() / shape.outputs;
        multiply(Matrix::new(inputs, samples, shape.inputs), matrix, Before::Replace, outputs);
    });
}

/// The gradient with respect to the inputs, written or added to what is there.
pub(crate) fn input_gradients(
    shape: DenseShape,
    matrix: &[f32],
    output_gradients: &[f32],
    before: Before,
    input_gradients: &mut [f32],
) {
    let matrix = Matrix::new(matrix, shape.inputs, shape.outputs).transposed();
    let gradients = output_gradients.par_chunks(SAMPLES * shape.outputs);
    let targets = input_gradients.par_chunks_mut(SAMPLES * shape.inputs);
    gradients.zip(targets).for_each(|(gradients, targets)| {
        let samples = gradients.len() / shape.outputs;
        multiply(Matrix::new(gradients, samples, shape.outputs), matrix, before, targets);
    });
}

/// The gradient with respect to the matrix: a block of its rows is one piece, so that each sum runs
/// over the batch in one order and no partial sums are kept.
pub(crate) fn matrix_gradient(
    shape: DenseShape,
    inputs: &[f32],
    output_gradients: &[f32],
    matrix_gradient: &mut [f32],
) {
    let samples = output_gradients.len() / shape.outputs;
    let inputs = Matrix::new(inputs, samples, shape.inputs);
    let gradients = Matrix::new(output_gradients, samples, shape.outputs);
    let blocks = matrix_gradient.par_chunks_mut(INPUTS * shape.outputs);
    blocks.enumerate().for_each(|(block, target)| {
        let start = block * INPUTS;
        let range = start..start + target.len() / shape.outputs;
        multiply(inputs.columns(range).transposed(), gradients, Before::Replace, target);
    });
}
