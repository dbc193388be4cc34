//! What weights a network may have.

use crate::layer::{Layer, Stored};
use crate::supported::ArchitectureError;
use half::f16;
use thiserror::Error;

/// Sums are kept so far below the largest `f32`, 3.4e38, that the rounding of millions of additions
/// does not reach it.
const LARGEST_SUM: f64 = 1e30;

/// Weights that are checked together, without a branch for each: they are a million.
const TOGETHER: usize = 1024;

/// The largest magnitude of an input.
pub(crate) const MAX_INPUT: f32 = 1024.0;

/// Weights that are no network's.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
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
        /// The largest magnitude that its sums could have.
        sum: f64,
    },
}

/// Checks that there are as many weights as these layers have, all of them finite.
pub(crate) fn check(layers: &[Layer], weights: &[Stored]) -> Result<(), WeightsError> {
    let expected = layers.iter().map(Layer::parameters).sum();
    if weights.len() != expected {
        return Err(WeightsError::Count { expected, found: weights.len() });
    }
    let is_finite = |weight: &Stored| f16::from_le_bytes(*weight).is_finite();
    let are_finite = |weights: &[Stored]| weights.iter().fold(true, |so_far, w| so_far & is_finite(w));
    if !weights.chunks(TOGETHER).all(are_finite)
        && let Some(at) = weights.iter().position(|weight| !is_finite(weight))
    {
        return Err(WeightsError::NotFinite { at, value: f16::from_le_bytes(weights[at]).to_f32() });
    }
    Ok(())
}

/// The largest magnitude of the sums of a network's layers, whatever its input.
///
/// Where none overflows, none is infinite or NaN, and so no result depends on how a processor treats
/// those.
#[derive(Debug, Default)]
pub(crate) struct Sums(Vec<f64>);

impl Sums {
    /// What the inputs of a layer can reach that reads the output of layer `source`, or the
    /// picture.
    pub(crate) fn of_input(&self, source: Option<usize>) -> f64 {
        let input = source.and_then(|source| self.0.get(source)).copied();
        input.unwrap_or(f64::from(MAX_INPUT))
    }

    /// Adds the next layer, whose sums can reach `sum`.
    ///
    /// # Errors
    /// Where they might overflow.
    pub(crate) fn add(&mut self, sum: f64) -> Result<(), WeightsError> {
        if sum > LARGEST_SUM {
            return Err(WeightsError::Overflow { layer: self.0.len(), sum });
        }
        self.0.push(sum);
        Ok(())
    }
}
