//! Another light, another camera.

use grasp_renders::random::{between, grain, normal, unit};
use rand_chacha::ChaCha8Rng;

use super::noise::{blur, smooth};
use super::picture::Picture;

/// Changes the tone curve, lets light fall from one side and in patches, blurs and adds grain.
pub(super) fn relight(picture: &mut Picture, rng: &mut ChaCha8Rng) {
    let side = picture.side;
    let gamma = libm::exp(0.4 * normal(rng)) as f32;
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(rng));
    let slope = 1.2 * unit(rng) / side as f64;
    let (across, down) = ((cos * slope) as f32, (sin * slope) as f32);
    let patches = patches(side, 0.6, 0.25, |rng| 2 + (unit(rng) * 5.0) as usize, rng);
    let spots = self::patches(side, 0.4, 0.1, |_| 13, rng);
    let brightest = picture.grey.iter().zip(&picture.mask).filter(|(_, m)| **m > 0.5);
    let brightest = brightest.fold(1e-3f32, |most, (grey, _)| most.max(*grey));
    let half = side as f32 / 2.0;
    for (at, x, y) in picture.pixels() {
        let mut grey = libm::powf((picture.grey[at] / brightest).max(1e-3), gamma);
        grey *= (1.0 + across * (x - half) + down * (y - half)).max(0.15);
        for field in [&patches, &spots].into_iter().flatten() {
            grey *= field[at];
        }
        picture.grey[at] = grey;
    }
    if unit(rng) < 0.5 {
        soften(picture, between(rng, [0.5, 1.8]) as f32);
    }
    let strength = 0.05 * (unit(rng) * unit(rng)) as f32;
    for grey in &mut picture.grey {
        *grey = (*grey * 0.7 + strength * grain(rng)).clamp(0.02, 1.0);
    }
}

/// Factors of the light over the picture, with some probability.
fn patches(
    side: usize,
    often: f64,
    strength: f64,
    cells: impl Fn(&mut ChaCha8Rng) -> usize,
    rng: &mut ChaCha8Rng,
) -> Option<Vec<f32>> {
    if unit(rng) >= often {
        return None;
    }
    let strength = (strength * unit(rng)) as f32;
    let cells = cells(rng);
    Some(smooth(side, cells, rng).into_iter().map(|v| libm::expf(strength * v)).collect())
}

/// Blurs the grey within the hand.
fn soften(picture: &mut Picture, sigma: f32) {
    let inside: Vec<f32> = picture.grey.iter().zip(&picture.mask).map(|(g, m)| g * m).collect();
    let grey = blur(&inside, picture.side, sigma);
    let share = blur(&picture.mask, picture.side, sigma);
    for (at, share) in share.iter().enumerate() {
        picture.grey[at] = if *share > 1e-2 { grey[at] / share } else { 0.0 };
    }
}
