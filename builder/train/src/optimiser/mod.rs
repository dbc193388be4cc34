//! How weights are moved, and their average.
//!
//! By [`Optimiser::Muon`] the kernels of all convolutions but the first, and the embedding's
//! matrix, go along their orthogonalised momentum ([`muon`]), all other parameters by Adam.

mod adam;
mod muon;

use crate::plan::{Plan, Treatment};
use adam::Adam;
use muon::Muon;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Times the learning rate: the share of a kernel or matrix that each step takes away.
const WEIGHT_DECAY: f32 = 0.02;
/// Values of a piece of work.
const PIECE: usize = 1 << 14;

/// How weights are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optimiser {
    /// Matrices along their orthogonalised momentum (K. Jordan, 2024), all else by Adam.
    #[default]
    Muon,
    /// All by Adam with decoupled weight decay.
    Adam,
}

/// What is remembered of the gradients: the running means of each and of its square. Where only the
/// momentum of a matrix is needed, it is in `first`, and `second` stays 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    pub(crate) first: Vec<f32>,
    pub(crate) second: Vec<f32>,
}

impl Moments {
    pub(crate) fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters] }
    }

    /// Moves the weights of a plan against `gradients`. `step` counts from 1.
    pub(crate) fn step(
        &mut self,
        plan: &Plan,
        optimiser: Optimiser,
        weights: &mut [f32],
        gradients: &[f32],
        step: u64,
        learning_rate: f32,
    ) {
        let adam = Adam::new(step, learning_rate, WEIGHT_DECAY);
        let muon = Muon::new(learning_rate, WEIGHT_DECAY);
        let mut rest = (weights, self.first.as_mut_slice(), self.second.as_mut_slice(), gradients);
        let mut parts = Vec::new();
        for (length, treatment) in plan.treatments() {
            let (weights, first, second, gradients) = rest;
            let (weights, more_weights) = weights.split_at_mut(length);
            let (first, more_first) = first.split_at_mut(length);
            let (second, more_second) = second.split_at_mut(length);
            let (gradients, more_gradients) = gradients.split_at(length);
            parts.push((treatment, weights, [first, second], gradients));
            rest = (more_weights, more_first, more_second, more_gradients);
        }
        parts.into_par_iter().for_each(|(treatment, weights, [first, second], gradients)| match treatment {
            Treatment::Plain { is_decayed } => adam.step(weights, [first, second], gradients, is_decayed),
            Treatment::Matrix { columns } if optimiser == Optimiser::Muon => {
                muon.step(weights, first, gradients, columns);
            }
            Treatment::Matrix { .. } => adam.step(weights, [first, second], gradients, true),
        });
    }
}

/// Moves `average` towards `values`: `decay` is the share of it that stays.
pub(crate) fn average(decay: f32, values: &[f32], average: &mut [f32]) {
    average.par_chunks_mut(PIECE).zip(values.par_chunks(PIECE)).for_each(|(average, values)| {
        for (average, value) in average.iter_mut().zip(values) {
            *average = decay * *average + (1.0 - decay) * value;
        }
    });
}

/// The learning rate of step `step` of `steps`: `peak` along half a cosine over all steps, times a
/// linear warm-up over the first 150, plus 1e-5.
pub fn learning_rate(peak: f32, step: u64, steps: u64) -> f32 {
    const WARM_UP: f32 = 150.0;
    const LEAST: f32 = 1e-5;
    let done = (step as f32 / steps.max(1) as f32).min(1.0);
    peak * ((step + 1) as f32 / WARM_UP).min(1.0) * (0.5 + 0.5 * (PI * done).cos()) + LEAST
}
