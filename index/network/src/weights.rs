//! What weights a network may have.

use crate::architecture::Architecture;
use crate::layer::Layer;
use crate::supported::ArchitectureError;
use half::f16;
use thiserror::Error;

/// Sums are kept so far below the largest `f32`, 3.4e38, that the rounding of millions of additions
/// does not reach it.
const LARGEST_SUM: f64 = 1e30;

/// The largest input, up or down.
pub(crate) const MAX_INPUT: f32 = 1024.0;

/// Weights that are no network's.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WeightsError {
    /// The shape is not supported.
    #[error(transparent)]
    Architecture(#[from] ArchitectureError),
    /// Too few or too many weights for the shape.
    #[error("{found} weights, where the architecture has {expected}")]
    Count {
        /// What the architecture has.
        expected: usize,
        /// What was given.
        found: usize,
    },
    /// A weight is NaN, or infinite once it is rounded to `f16`.
    #[error("weight {at} is {value} as f16, where -65504 to 65504 are supported")]
    NotFinite {
        /// The weight's place in the array.
        at: usize,
        /// What it is.
        value: f32,
    },
    /// Some input to [`crate::Network::MAX_INPUT`] could make sums overflow.
    #[error("the weights of layer {layer} are so large that its sums could reach {sum:.1e}")]
    Overflow {
        /// The layer, counted from 0.
        layer: usize,
        /// What its sums could reach, up or down.
        sum: f64,
    },
}

/// Checks the weights of a network with these layers. Returns them as `f32`, which is exact.
///
/// Where no sum overflows, none is infinite or NaN, and so no result depends on how a processor
/// treats those.
pub(crate) fn check(
    architecture: &Architecture,
    layers: &[Layer],
    weights: &[f16],
) -> Result<Vec<f32>, WeightsError> {
    let expected = layers.iter().map(Layer::parameters).sum();
    if weights.len() != expected {
        return Err(WeightsError::Count { expected, found: weights.len() });
    }
    if let Some(at) = weights.iter().position(|weight| !weight.is_finite()) {
        return Err(WeightsError::NotFinite { at, value: weights[at].to_f32() });
    }
    let weights: Vec<f32> = weights.iter().map(|weight| weight.to_f32()).collect();
    let mut rest = weights.as_slice();
    let mut sums: Vec<f64> = Vec::with_capacity(layers.len());
    for (at, layer) in layers.iter().enumerate() {
        let (parameters, after) = rest.split_at(layer.parameters());
        let input = architecture.source(at).and_then(|source| sums.get(source)).copied();
        let sum = largest_sum(layer, parameters, input.unwrap_or(f64::from(MAX_INPUT)));
        if sum > LARGEST_SUM {
            return Err(WeightsError::Overflow { layer: at, sum });
        }
        sums.push(sum);
        rest = after;
    }
    Ok(weights)
}

/// What the sums of a layer can reach, up or down, with inputs to `input`.
fn largest_sum(layer: &Layer, parameters: &[f32], input: f64) -> f64 {
    let outputs = layer.output_planes;
    let (matrix, bias) = parameters.split_at(layer.inputs() * outputs);
    let mut sums: Vec<f64> = bias.iter().map(|&bias| f64::from(bias).abs()).collect();
    for row in matrix.chunks_exact(outputs) {
        for (sum, &weight) in sums.iter_mut().zip(row) {
            *sum += input * f64::from(weight).abs();
        }
    }
    sums.into_iter().fold(0.0, f64::max)
}
