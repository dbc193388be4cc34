//! Adam with decoupled weight decay, and the average of the weights.
//!
//! Kingma and Ba, "Adam", 2015; Loshchilov and Hutter, "Decoupled weight decay regularization",
//! 2019.

use rayon::prelude::*;
use std::f32::consts::PI;

const FIRST_DECAY: f32 = 0.9;
const SECOND_DECAY: f32 = 0.99;
/// Added to the root of the second moment.
const EPSILON: f32 = 1e-7;
/// Times the learning rate: the share of a kernel or matrix that each step takes away.
const WEIGHT_DECAY: f32 = 0.02;
/// Values a piece of work.
const PIECE: usize = 1 << 14;

/// The running means of the gradient and its square.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    pub(crate) first: Vec<f32>,
    pub(crate) second: Vec<f32>,
}

impl Moments {
    pub(crate) fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters] }
    }

    /// Moves `weights` against `gradients`. `step` counts from 1; `decayed` is 1 where weight decay
    /// applies and 0 elsewhere.
    pub(crate) fn step(
        &mut self,
        weights: &mut [f32],
        gradients: &[f32],
        decayed: &[f32],
        step: u64,
        learning_rate: f32,
    ) {
        let correction = |decay: f32| (1.0 / (1.0 - f64::from(decay).powf(step as f64))) as f32;
        let (first_correction, second_correction) = (correction(FIRST_DECAY), correction(SECOND_DECAY));
        let pieces = weights.par_chunks_mut(PIECE).zip(gradients.par_chunks(PIECE));
        let moments = self.first.par_chunks_mut(PIECE).zip(self.second.par_chunks_mut(PIECE));
        let pieces = pieces.zip(moments).zip(decayed.par_chunks(PIECE));
        pieces.for_each(|(((weights, gradients), (first, second)), decayed)| {
            let values = weights.iter_mut().zip(gradients).zip(decayed);
            for (((w, g), decayed), (m, v)) in values.zip(first.iter_mut().zip(second)) {
                *m = FIRST_DECAY * *m + (1.0 - FIRST_DECAY) * g;
                *v = SECOND_DECAY * *v + (1.0 - SECOND_DECAY) * g * g;
                let update = (*m * first_correction) / ((*v * second_correction).sqrt() + EPSILON);
                *w -= learning_rate * (update + WEIGHT_DECAY * decayed * *w);
            }
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

/// The learning rate of step `step` of `steps`: rises to `peak` over the first 150 steps, then
/// falls to almost 0 along half a cosine.
pub fn learning_rate(peak: f32, step: u64, steps: u64) -> f32 {
    const WARM_UP: f32 = 150.0;
    const LEAST: f32 = 1e-5;
    let done = (step as f32 / steps.max(1) as f32).min(1.0);
    peak * ((step + 1) as f32 / WARM_UP).min(1.0) * (0.5 + 0.5 * (PI * done).cos()) + LEAST
}
