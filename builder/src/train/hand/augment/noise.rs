//! Random fields, cheaply.

use grasp_renders::random::normal;
use rand_chacha::ChaCha8Rng;

/// A smooth random field of about unit variance over a square picture, with `cells` bumps a side.
pub(super) fn smooth(side: usize, cells: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
    let across = cells + 2;
    let corners: Vec<f32> = (0..across * across).map(|_| normal(rng) as f32).collect();
    let mut field = Vec::with_capacity(side * side);
    for y in 0..side {
        let v = y as f32 * cells as f32 / side as f32;
        let (b, v) = (v as usize, v.fract());
        for x in 0..side {
            let u = x as f32 * cells as f32 / side as f32;
            let (a, u) = (u as usize, u.fract());
            let row = |b: usize| corners[b * across + a] * (1.0 - u) + corners[b * across + a + 1] * u;
            field.push(row(b) * (1.0 - v) + row(b + 1) * v);
        }
    }
    field
}

/// A Gaussian blur of standard deviation `sigma` pixels; what lies outside the picture counts as 0.
pub(super) fn blur(values: &[f32], side: usize, sigma: f32) -> Vec<f32> {
    let reach = (2.5 * sigma).ceil() as usize;
    let mut kernel: Vec<f32> =
        (0..=reach).map(|i| i as f32 / sigma).map(|x| libm::expf(-0.5 * x * x)).collect();
    let sum = 2.0 * kernel.iter().sum::<f32>() - kernel[0];
    kernel.iter_mut().for_each(|weight| *weight /= sum);
    let pass = |values: &[f32], out: &mut [f32], stride: usize, across: usize| {
        for line in 0..side {
            for i in 0..side {
                let at = line * across + i * stride;
                let mut sum = kernel[0] * values[at];
                for (d, weight) in kernel.iter().enumerate().skip(1) {
                    if i >= d {
                        sum += weight * values[at - d * stride];
                    }
                    if i + d < side {
                        sum += weight * values[at + d * stride];
                    }
                }
                out[at] = sum;
            }
        }
    };
    let (mut once, mut twice) = (vec![0.0; values.len()], vec![0.0; values.len()]);
    pass(values, &mut once, 1, side);
    pass(&once, &mut twice, side, 1);
    twice
}
