//! The network as its definition says, in f64 and plain loops.

use crate::affine::Affine;
use crate::dropout::drop_values;
use crate::plan::{MaskPlan, Plan};
use grasp_network::{Architecture, Layer};

/// One sample through one convolution, without a bias.
fn convolve(shape: &Layer, kernel: &[f64], input: &[f64]) -> Vec<f64> {
    let (side, planes, padding) = (shape.input_side, shape.input_planes, shape.padding);
    let mut output = vec![0.0; shape.output_values()];
    for y in 0..shape.output_side {
        for x in 0..shape.output_side {
            for o in 0..shape.output_planes {
                let mut sum = 0.0;
                for ky in 0..shape.kernel {
                    for kx in 0..shape.kernel {
                        let (row, column) = (y * shape.stride + ky, x * shape.stride + kx);
                        let inside = padding..side + padding;
                        if !inside.contains(&row) || !inside.contains(&column) {
                            continue;
                        }
                        for p in 0..planes {
                            let at = ((row - padding) * side + column - padding) * planes + p;
                            let tap = (ky * shape.kernel + kx) * planes + p;
                            sum += input[at] * kernel[tap * shape.output_planes + o];
                        }
                    }
                }
                output[(y * shape.output_side + x) * shape.output_planes + o] = sum;
            }
        }
    }
    output
}

/// One sample through a matrix.
fn dense(matrix: &[f64], outputs: usize, input: &[f64]) -> Vec<f64> {
    let column = |o| input.iter().enumerate().map(|(i, v)| v * matrix[i * outputs + o]).sum();
    (0..outputs).map(column).collect()
}

/// Normalises all samples by their own statistics and rectifies.
fn normalise(samples: &mut [Vec<f64>], scale: &[f64], shift: &[f64], slope: f64) {
    let planes = scale.len();
    for plane in 0..planes {
        let values = || samples.iter().flat_map(|sample| sample[plane..].iter().step_by(planes));
        let count = values().count() as f64;
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        for value in samples.iter_mut().flat_map(|sample| sample[plane..].iter_mut().step_by(planes)) {
            let y = (*value - mean) / (variance + 1e-3).sqrt() * scale[plane] + shift[plane];
            *value = if y > 0.0 { y } else { slope * y };
        }
    }
}

/// One sample through a layer with a bias.
fn affine(layer: &Affine, parameters: &[f64], input: &[f64]) -> Vec<f64> {
    let outputs = dense(&parameters[layer.matrix.clone()], layer.shape.outputs, input);
    outputs.into_iter().zip(&parameters[layer.bias.clone()]).map(|(v, bias)| v + bias).collect()
}

/// The outputs of a batch in training: the heads of all samples, then the masks of all in the order
/// of their layer, then the joints of all.
pub(super) fn forward(plan: &Plan, parameters: &[f64], inputs: &[f32], dropout: u64) -> Vec<f64> {
    let wide = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect::<Vec<_>>();
    let mut samples: Vec<_> = inputs.chunks(plan.inputs()).map(wide).collect();
    let mut masks = Vec::new();
    for (index, (shape, block)) in plan.convolutions.iter().zip(&plan.blocks).enumerate() {
        let kernel = &parameters[block.matrix.clone()];
        samples.iter_mut().for_each(|sample| *sample = convolve(shape, kernel, sample));
        normalise(&mut samples, &parameters[block.scale.clone()], &parameters[block.shift.clone()], 0.0);
        if let Some(MaskPlan { layer, .. }) = plan.masks_of(index) {
            let pixels = samples.iter().flat_map(|sample| sample.chunks(layer.shape.inputs));
            masks.extend(pixels.flat_map(|pixel| affine(layer, parameters, pixel)));
        }
    }
    let block = plan.blocks.last().expect("the embedding");
    for (index, sample) in samples.iter_mut().enumerate() {
        let mut factors = vec![0.0; sample.len()];
        drop_values(dropout, index, &vec![1.0; sample.len()], &mut factors);
        sample.iter_mut().zip(factors).for_each(|(v, factor)| *v *= f64::from(factor));
        *sample = dense(&parameters[block.matrix.clone()], block.outputs, sample);
    }
    let (scale, shift) = (&parameters[block.scale.clone()], &parameters[block.shift.clone()]);
    normalise(&mut samples, scale, shift, f64::from(Architecture::LEAK));
    let heads = samples.iter().flat_map(|sample| affine(&plan.head, parameters, sample));
    let joint = |layer| samples.iter().flat_map(move |sample| affine(layer, parameters, sample));
    heads.chain(masks).chain(plan.joints.iter().flat_map(joint)).collect()
}

/// The heads of one sample by folded weights, in the layout of [`Architecture`].
pub(super) fn folded_outputs(plan: &Plan, weights: &[f32], input: &[f32]) -> Vec<f64> {
    let mut rest = weights;
    let mut take = |count: usize| {
        let (first, after) = rest.split_at(count);
        rest = after;
        first.iter().map(|&v| f64::from(v)).collect::<Vec<_>>()
    };
    let biased = |values: &mut Vec<f64>, bias: &[f64], slope: f64| {
        for (index, value) in values.iter_mut().enumerate() {
            *value += bias[index % bias.len()];
            *value = if *value > 0.0 { *value } else { slope * *value };
        }
    };
    let mut values: Vec<_> = input.iter().map(|&v| f64::from(v)).collect();
    for shape in &plan.convolutions {
        values = convolve(shape, &take(shape.inputs() * shape.output_planes), &values);
        biased(&mut values, &take(shape.output_planes), 0.0);
    }
    values = dense(&take(plan.features * plan.embedding()), plan.embedding(), &values);
    biased(&mut values, &take(plan.embedding()), f64::from(Architecture::LEAK));
    values = dense(&take(plan.embedding() * plan.heads()), plan.heads(), &values);
    biased(&mut values, &take(plan.heads()), 1.0);
    assert!(rest.is_empty(), "weights left over");
    values
}
