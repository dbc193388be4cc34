//! Adam with decoupled weight decay.
//!
//! Kingma and Ba, "Adam", 2015; Loshchilov and Hutter, "Decoupled weight decay regularization",
//! 2019.

const FIRST_DECAY: f32 = 0.9;
const SECOND_DECAY: f32 = 0.99;
/// Added to the root of the second moment.
const EPSILON: f32 = 1e-7;

/// What becomes of the moments, which are 0 at first, in a step.
pub(super) struct Adam {
    learning_rate: f32,
    weight_decay: f32,
    first_correction: f32,
    second_correction: f32,
}

impl Adam {
    /// `step` counts from 1.
    pub(super) fn new(step: u64, learning_rate: f32, weight_decay: f32) -> Self {
        let correction = |decay: f32| (1.0 / (1.0 - f64::from(decay).powf(step as f64))) as f32;
        let (first_correction, second_correction) = (correction(FIRST_DECAY), correction(SECOND_DECAY));
        Self { learning_rate, weight_decay, first_correction, second_correction }
    }

    /// Moves `weights` against `gradients`, by the running means of the gradient and its square.
    pub(super) fn step(
        &self,
        weights: &mut [f32],
        [first, second]: [&mut [f32]; 2],
        gradients: &[f32],
        is_decayed: bool,
    ) {
        let weight_decay = if is_decayed { self.weight_decay } else { 0.0 };
        let values = weights.iter_mut().zip(gradients).zip(first.iter_mut().zip(second));
        for ((w, g), (m, v)) in values {
            *m = FIRST_DECAY * *m + (1.0 - FIRST_DECAY) * g;
            *v = SECOND_DECAY * *v + (1.0 - SECOND_DECAY) * g * g;
            let update = (*m * self.first_correction) / ((*v * self.second_correction).sqrt() + EPSILON);
            *w -= self.learning_rate * (update + weight_decay * *w);
        }
    }
}
