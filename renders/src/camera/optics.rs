//! From light to a picture file: blur, exposure, noise, compression.

use rand_chacha::ChaCha8Rng;

use crate::random::{between, grain, normal, unit};

/// How often a camera sharpens what it has taken.
const SHARPENED: f64 = 0.3;

/// From how many pixels a texel on its corners would show, and by what share of its width they are
/// blurred (standard deviation), at most so many: an enlarged photograph is soft, not jagged.
const ENLARGED: f32 = 0.7;
const SOFT: f32 = 0.5;
const SOFTEST: f32 = 2.0;

/// Turns a square of linear RGB values into those of a picture, 0 to 1, in place; `enlarged` is how
/// many pixels a texel of its view is wide.
pub(super) fn develop(rgb: &mut [f32], side: usize, enlarged: f32, rng: &mut ChaCha8Rng) {
    if enlarged > ENLARGED {
        blur(rgb, side, (SOFT * enlarged).min(SOFTEST), [1.0, 1.0]);
    }
    if unit(rng) < 0.5 {
        blur(rgb, side, between(rng, [0.3, 0.9]) as f32, [1.0, 1.0]);
    }
    if unit(rng) < 0.08 {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(rng));
        blur(rgb, side, between(rng, [0.8, 2.0]) as f32, [cos.abs() as f32, sin.abs() as f32]);
    }
    expose(rgb, rng);
    if unit(rng) < SHARPENED {
        sharpen(rgb, side, between(rng, [0.7, 1.3]) as f32, between(rng, [0.2, 0.8]) as f32);
    }
    if unit(rng) < 0.5 {
        smear_colours(rgb, side, (1.0 + 3.0 * unit(rng)) as usize);
    }
    let noise = 0.03 * (unit(rng) * unit(rng)) as f32;
    for value in rgb {
        *value = (*value + noise * grain(rng)).clamp(0.0, 1.0);
    }
}

/// The same as a camera without faults would: it brings the mean to about a sixth.
pub(super) fn develop_ideally(rgb: &mut [f32]) {
    let mean = rgb.iter().sum::<f32>() / rgb.len().max(1) as f32;
    let (gain, curve) = (0.17 / mean.max(0.01), Curve::power(1.0 / 2.2));
    rgb.iter_mut().for_each(|value| *value = curve.at(*value * gain));
}

/// Brightness, white balance, tone curve, contrast and saturation.
fn expose(rgb: &mut [f32], rng: &mut ChaCha8Rng) {
    let mean = rgb.iter().sum::<f32>() / rgb.len().max(1) as f32;
    // A camera brings the mean to about a sixth; not always.
    let gain =
        libm::pow(0.17 / f64::from(mean.max(0.01)), between(rng, [0.5, 1.0])) * libm::exp(0.28 * normal(rng));
    // Too warm or too cold more often than too green.
    let cold = 0.03 + 0.1 * normal(rng);
    let white: [f32; 3] =
        [-cold, 0.0, cold].map(|shift| (libm::exp(shift + 0.07 * normal(rng)) * gain) as f32);
    let gamma = (between(rng, [0.8, 1.25]) / 2.2) as f32;
    let (contrast, saturation) = (between(rng, [0.8, 1.35]) as f32, between(rng, [0.5, 1.3]) as f32);
    let black = 0.06 * unit(rng) as f32;
    let curve = Curve::power(gamma);
    for pixel in rgb.as_chunks_mut::<3>().0 {
        let toned: [f32; 3] = std::array::from_fn(|i| curve.at(pixel[i] * white[i]));
        let grey = 0.3 * toned[0] + 0.59 * toned[1] + 0.11 * toned[2];
        *pixel = toned.map(|v| {
            let v = grey + (v - grey) * saturation;
            black + (0.5 + (v - 0.5) * contrast) * (1.0 - black)
        });
    }
}

/// A tone curve from 0 to 1, looked up: a power for each value of a picture takes longer than all
/// the rest.
struct Curve(Vec<f32>);

impl Curve {
    const STEPS: usize = 512;

    fn power(exponent: f32) -> Self {
        // Steps are even in the root of the value, where the curve is nearly straight.
        let root = |step: usize| step as f32 / Self::STEPS as f32;
        Self((0..=Self::STEPS).map(|step| libm::powf(root(step), 2.0 * exponent)).collect())
    }

    fn at(&self, value: f32) -> f32 {
        let place = value.clamp(0.0, 1.0).sqrt() * Self::STEPS as f32;
        let step = (place as usize).min(Self::STEPS - 1);
        let (low, high) = (self.0[step], self.0[step + 1]);
        low + (high - low) * (place - step as f32)
    }
}

/// Colours are kept at a lower resolution than brightness, as in JPEG files.
fn smear_colours(rgb: &mut [f32], side: usize, cell: usize) {
    let grey = |pixel: &[f32]| 0.3 * pixel[0] + 0.59 * pixel[1] + 0.11 * pixel[2];
    for top in (0..side).step_by(cell.max(1)) {
        for left in (0..side).step_by(cell.max(1)) {
            let places = || {
                let rows = top..(top + cell).min(side);
                rows.flat_map(move |y| (left..(left + cell).min(side)).map(move |x| 3 * (y * side + x)))
            };
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for at in places() {
                let pixel = &rgb[at..at + 3];
                let grey = grey(pixel);
                (0..3).for_each(|i| sum[i] += pixel[i] - grey);
                count += 1.0;
            }
            for at in places() {
                let grey = grey(&rgb[at..at + 3]);
                (0..3).for_each(|i| rgb[at + i] = grey + sum[i] / count);
            }
        }
    }
}

/// Adds so much of what a blur takes away.
fn sharpen(rgb: &mut [f32], side: usize, sigma: f32, amount: f32) {
    let mut blurred = rgb.to_vec();
    blur(&mut blurred, side, sigma, [1.0, 1.0]);
    rgb.iter_mut().zip(blurred).for_each(|(value, smooth)| *value += amount * (*value - smooth));
}

/// A Gaussian blur whose standard deviation, in pixels, has such shares right and down.
pub(super) fn blur(rgb: &mut [f32], side: usize, sigma: f32, shares: [f32; 2]) {
    for (share, [line, step]) in shares.into_iter().zip([[side, 1], [1, side]]) {
        let sigma = sigma * share;
        if sigma < 0.2 {
            continue;
        }
        let reach = (2.0 * sigma).ceil() as usize;
        let mut kernel: Vec<f32> =
            (0..=reach).map(|i| libm::expf(-0.5 * (i as f32 / sigma).powi(2))).collect();
        let sum = 2.0 * kernel.iter().sum::<f32>() - kernel[0];
        kernel.iter_mut().for_each(|weight| *weight /= sum);
        let mut row = vec![[0.0f32; 3]; side];
        for start in 0..side {
            for (i, to) in row.iter_mut().enumerate() {
                *to = [0.0; 3];
                for (d, weight) in kernel.iter().enumerate() {
                    for at in [i.saturating_sub(d), (i + d).min(side - 1)] {
                        let weight = if d == 0 { 0.5 * weight } else { *weight };
                        let from = 3 * (start * line + at * step);
                        (0..3).for_each(|c| to[c] += weight * rgb[from + c]);
                    }
                }
            }
            for (i, values) in row.iter().enumerate() {
                let to = 3 * (start * line + i * step);
                rgb[to..to + 3].copy_from_slice(values);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_blur_keeps_the_sum_and_an_even_picture() {
        let mut even = vec![0.4; 3 * 16 * 16];
        blur(&mut even, 16, 1.3, [1.0, 0.5]);
        assert!(even.iter().all(|v| (v - 0.4).abs() < 1e-5));
        let mut dot = vec![0.0; 3 * 16 * 16];
        dot[3 * (8 * 16 + 8)] = 1.0;
        blur(&mut dot, 16, 1.0, [1.0, 1.0]);
        assert!((dot.iter().sum::<f32>() - 1.0).abs() < 1e-4 && dot[3 * (8 * 16 + 9)] > 0.05);
    }

    #[test]
    fn sharpening_steepens_an_edge_and_keeps_an_even_picture() {
        let mut even = vec![0.4; 3 * 16 * 16];
        sharpen(&mut even, 16, 1.0, 1.0);
        assert!(even.iter().all(|v| (v - 0.4).abs() < 1e-5));
        let mut edge: Vec<f32> = (0..3 * 16 * 16).map(|at| if at / 3 % 16 < 8 { 0.3 } else { 0.6 }).collect();
        sharpen(&mut edge, 16, 1.0, 1.0);
        let at = |x: usize| edge[3 * (8 * 16 + x)];
        assert!(at(7) < 0.25 && at(8) > 0.65 && (at(1) - 0.3).abs() < 1e-4, "{} {}", at(7), at(8));
    }

    #[test]
    fn a_curve_is_its_power() {
        let curve = Curve::power(0.45);
        for step in 0..=100 {
            let value = step as f32 / 100.0;
            assert!((curve.at(value) - libm::powf(value, 0.45)).abs() < 2e-3, "{value}");
        }
    }

    #[test]
    fn pictures_are_in_range() {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut rgb: Vec<f32> = (0..3 * 32 * 32).map(|_| 2.0 * unit(&mut rng) as f32).collect();
            develop(&mut rgb, 32, 0.5 * (1 + seed % 4) as f32, &mut rng);
            assert!(rgb.iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }
}
