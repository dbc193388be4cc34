//! Convolution as a product of matrices, for a few samples at a time.

use crate::columns::{gather, scatter};
use crate::matrix::{Before, Matrix, multiply};
use grasp_network::Layer;

/// Values of the columns that are made at once: about a core's second-level cache, and rows enough
/// that the packing of the kernel is paid for. Half as many were slower by a sixth.
const COLUMNS: usize = 256 << 10;

fn pixels(shape: &Layer) -> usize {
    shape.output_side * shape.output_side
}

/// Samples whose columns are made at once.
fn samples_at_once(shape: &Layer) -> usize {
    (COLUMNS / (pixels(shape) * shape.inputs())).max(1)
}

/// `outputs = inputs * kernel`, without a bias: the normalisation that follows would take it away.
pub(crate) fn forward(
    shape: &Layer,
    kernel: &[f32],
    inputs: &[f32],
    outputs: &mut [f32],
    columns: &mut Vec<f32>,
) {
    let kernel = Matrix::new(kernel, shape.inputs(), shape.output_planes);
    let samples = samples_at_once(shape);
    let inputs = inputs.chunks(samples * shape.input_values());
    for (inputs, outputs) in inputs.zip(outputs.chunks_mut(samples * shape.output_values())) {
        let left = columns_of(shape, inputs, columns);
        multiply(left, kernel, Before::Replace, outputs);
    }
}

/// Writes the gradient with respect to the kernel and, where asked for, the inputs.
pub(crate) fn backward(
    shape: &Layer,
    kernel: &[f32],
    inputs: &[f32],
    output_gradients: &[f32],
    kernel_gradient: &mut [f32],
    mut input_gradients: Option<&mut [f32]>,
    columns: &mut Vec<f32>,
) {
    let (taps, pixels) = (shape.inputs(), pixels(shape));
    let samples = samples_at_once(shape);
    let chunks = inputs.chunks(samples * shape.input_values());
    let gradients = output_gradients.chunks(samples * shape.output_values());
    kernel_gradient.fill(0.0);
    for (chunk, (inputs, gradients)) in chunks.zip(gradients).enumerate() {
        let left = columns_of(shape, inputs, columns);
        let gradients = Matrix::new(gradients, gradients.len() / shape.output_planes, shape.output_planes);
        multiply(left.transposed(), gradients, Before::Add, kernel_gradient);
        let Some(all) = &mut input_gradients else { continue };
        let start = chunk * samples * shape.input_values();
        let target = &mut all[start..start + inputs.len()];
        multiply(
            gradients,
            Matrix::new(kernel, taps, shape.output_planes).transposed(),
            Before::Replace,
            columns,
        );
        target.fill(0.0);
        let sample_columns = columns.chunks(pixels * taps);
        for (target, columns) in target.chunks_mut(shape.input_values()).zip(sample_columns) {
            scatter(shape, columns, target);
        }
    }
}

/// The columns of a few samples, one below the other.
fn columns_of<'a>(shape: &Layer, inputs: &[f32], columns: &'a mut Vec<f32>) -> Matrix<'a> {
    let (taps, pixels) = (shape.inputs(), pixels(shape));
    let samples = inputs.len() / shape.input_values();
    columns.resize(samples * pixels * taps, 0.0);
    let inputs = inputs.chunks(shape.input_values());
    for (input, columns) in inputs.zip(columns.chunks_mut(pixels * taps)) {
        gather(shape, input, columns);
    }
    Matrix::new(columns, samples * pixels, taps)
}
