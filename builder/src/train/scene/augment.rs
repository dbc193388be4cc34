//! Makes a scene harder than any camera would: colours that mean nothing, structure that is
//! filtered anew, less of everything. What is left to learn from is the shape.

use grasp_renders::Picture;
use grasp_renders::random::{between, grain, normal, unit};
use rand_chacha::ChaCha8Rng;

/// How often a picture loses its colours; else, how often they are mixed.
const GREY: f64 = 0.25;
const MIXED: f64 = 0.5;
/// How often it is filtered at random, has few pixels, is noisy, is hidden in places.
const FILTERED: f64 = 0.35;
const COARSE: f64 = 0.25;
const NOISY: f64 = 0.3;
const HIDDEN: f64 = 0.3;

/// Changes a picture, and its masks where something comes before the hand.
pub(super) fn augment(picture: &mut Picture, rng: &mut ChaCha8Rng) {
    if unit(rng) < HIDDEN {
        hide(picture, rng);
    }
    let (side, rgb) = (picture.side, &mut picture.rgb);
    if unit(rng) < GREY {
        mix(rgb, [0; 3].map(|_| [0.3, 0.59, 0.11]));
    } else if unit(rng) < MIXED {
        mix_at_random(rgb, rng);
    }
    if unit(rng) < FILTERED {
        filter(rgb, side, rng);
    }
    if unit(rng) < COARSE {
        coarsen(rgb, side, between(rng, [24.0, 52.0]) as usize);
    }
    let noise = if unit(rng) < NOISY { (0.08 * unit(rng)) as f32 } else { 0.0 };
    for value in rgb {
        *value = (*value + noise * grain(rng)).clamp(0.0, 1.0);
    }
}

/// Each colour becomes a sum of all.
fn mix(rgb: &mut [f32], sums: [[f32; 3]; 3]) {
    for pixel in rgb.as_chunks_mut::<3>().0 {
        let old = *pixel;
        *pixel = sums.map(|sum| (0..3).map(|i| sum[i] * old[i]).sum());
    }
}

fn mix_at_random(rgb: &mut [f32], rng: &mut ChaCha8Rng) {
    let strength = 0.35 * unit(rng);
    let sums = [0, 1, 2].map(|to| {
        let mut sum = [0, 1, 2].map(|from| f64::from(u8::from(to == from)) + strength * normal(rng));
        // White keeps about its brightness.
        let (whole, tint) = (sum.iter().sum::<f64>(), libm::exp(0.4 * strength * normal(rng)));
        sum.iter_mut().for_each(|v| *v *= tint / whole.abs().max(0.4));
        sum.map(|v| v as f32)
    });
    mix(rgb, sums);
}

/// Filters by a random kernel, which leaves mean and spread as they are, and mixes the outcome with
/// the picture (Xu et al., "Robust and generalizable visual representation learning via random
/// convolutions", ICLR 2021).
fn filter(rgb: &mut [f32], side: usize, rng: &mut ChaCha8Rng) {
    let step = [1, 1, 2][(3.0 * unit(rng)) as usize];
    let kernel: [[[f32; 3]; 9]; 3] = [0; 3].map(|_| [0; 9].map(|_| [0; 3].map(|_| normal(rng) as f32)));
    let share = (0.6 * unit(rng)) as f32;
    let near = |at: usize, by: usize| (at + by * step).saturating_sub(step).min(side - 1);
    let mut filtered = Vec::with_capacity(rgb.len());
    for at in 0..side * side {
        let (x, y) = (at % side, at / side);
        let mut sums = [0.0; 3];
        for tap in 0..9 {
            let from = 3 * (near(y, tap / 3) * side + near(x, tap % 3));
            let pixel = &rgb[from..from + 3];
            for (sum, kernel) in sums.iter_mut().zip(&kernel) {
                *sum += kernel[tap].iter().zip(pixel).map(|(weight, value)| weight * value).sum::<f32>();
            }
        }
        filtered.extend(sums);
    }
    let moments = |values: &[f32], colour: usize| {
        let of = || values.iter().skip(colour).step_by(3);
        let mean = of().sum::<f32>() / (side * side) as f32;
        let spread = of().map(|v| (v - mean) * (v - mean)).sum::<f32>() / (side * side) as f32;
        (mean, spread.sqrt().max(1e-3))
    };
    for colour in 0..3 {
        let ((mean, spread), (other_mean, other)) = (moments(rgb, colour), moments(&filtered, colour));
        for (value, new) in rgb.iter_mut().zip(&filtered).skip(colour).step_by(3) {
            *value += share * (mean + (new - other_mean) * spread / other - *value);
        }
    }
}

/// As if it had had `pixels` pixels a side.
fn coarsen(rgb: &mut [f32], side: usize, pixels: usize) {
    let (mut sums, mut counts) = (vec![0.0; 3 * pixels * pixels], vec![0.0f32; pixels * pixels]);
    let cell = |at: usize| (at * pixels / side).min(pixels - 1);
    for (at, pixel) in rgb.as_chunks::<3>().0.iter().enumerate() {
        let to = cell(at / side) * pixels + cell(at % side);
        counts[to] += 1.0;
        (0..3).for_each(|i| sums[3 * to + i] += pixel[i]);
    }
    let at = |x: usize, y: usize, i: usize| sums[3 * (y * pixels + x) + i] / counts[y * pixels + x].max(1.0);
    let split = |to: usize| {
        let place = ((to as f32 + 0.5) * pixels as f32 / side as f32 - 0.5).clamp(0.0, (pixels - 1) as f32);
        let low = place as usize;
        (low, (low + 1).min(pixels - 1), place - low as f32)
    };
    for to in 0..side * side {
        let ((left, right, u), (top, bottom, v)) = (split(to % side), split(to / side));
        for i in 0..3 {
            let row = |y: usize| at(left, y, i) * (1.0 - u) + at(right, y, i) * u;
            rgb[3 * to + i] = row(top) * (1.0 - v) + row(bottom) * v;
        }
    }
}

/// Puts up to three plain or noisy boxes before the picture.
fn hide(picture: &mut Picture, rng: &mut ChaCha8Rng) {
    let side = picture.side;
    for _ in 0..1 + (3.0 * unit(rng)) as usize {
        let [wide, high] = [0; 2].map(|_| between(rng, [0.08, 0.35]));
        let (left, top) = (between(rng, [-0.1, 1.0]), between(rng, [-0.1, 1.0]));
        let range = |from: f64, length: f64| {
            let at = |place: f64| (place.clamp(0.0, 1.0) * side as f64) as usize;
            at(from)..at(from + length)
        };
        let colour = [0; 3].map(|_| unit(rng) as f32);
        let noise = if unit(rng) < 0.4 { (0.3 * unit(rng)) as f32 } else { 0.0 };
        for y in range(top, high) {
            for x in range(left, wide) {
                let at = y * side + x;
                (0..3)
                    .for_each(|i| picture.rgb[3 * at + i] = (colour[i] + noise * grain(rng)).clamp(0.0, 1.0));
                picture.masks.iter_mut().for_each(|mask| mask[at] = 0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    const SIDE: usize = 32;

    /// Colours of a slope, and masks that are whole.
    fn picture() -> Picture {
        let rgb =
            (0..3 * SIDE * SIDE).map(|at| (at / 3 % SIDE) as f32 / SIDE as f32 * [1.0, 0.7, 0.4][at % 3]);
        Picture { side: SIDE, rgb: rgb.collect(), masks: [0; 3].map(|_| vec![1.0; SIDE * SIDE]) }
    }

    #[test]
    fn pictures_stay_in_range_and_masks_only_lose() {
        let mut hidden = 0;
        for seed in 0..60 {
            let mut changed = picture();
            augment(&mut changed, &mut ChaCha8Rng::seed_from_u64(seed));
            assert!(changed.rgb.iter().all(|value| (0.0..=1.0).contains(value)), "{seed}");
            assert!(changed.masks.iter().flatten().all(|share| [0.0, 1.0].contains(share)));
            hidden += usize::from(changed.masks[0].contains(&0.0));
        }
        assert!((6..40).contains(&hidden), "{hidden} of 60");
    }

    #[test]
    fn a_filter_keeps_each_colours_mean() {
        let mean = |rgb: &[f32], colour: usize| rgb.iter().skip(colour).step_by(3).sum::<f32>() / 1024.0;
        for seed in 0..8 {
            let (old, mut new) = (picture().rgb, picture().rgb);
            filter(&mut new, SIDE, &mut ChaCha8Rng::seed_from_u64(seed));
            assert_ne!(old, new);
            assert!((0..3).all(|colour| (mean(&old, colour) - mean(&new, colour)).abs() < 1e-3));
        }
    }

    #[test]
    fn few_pixels_keep_an_even_picture_and_smooth_a_grain() {
        let mut even = vec![0.3; 3 * SIDE * SIDE];
        coarsen(&mut even, SIDE, 13);
        assert!(even.iter().all(|value| (value - 0.3).abs() < 1e-5));
        let mut checks: Vec<f32> =
            (0..3 * SIDE * SIDE).map(|at| ((at / 3 + at / 3 / SIDE) % 2) as f32).collect();
        coarsen(&mut checks, SIDE, 16);
        assert!(checks.iter().all(|value| (value - 0.5).abs() < 1e-5));
    }
}
