//! A smooth random field over the plane and over space.

use rand_chacha::ChaCha8Rng;

use crate::random::unit;

/// Values a side; the field repeats after so many units.
const SIDE: usize = 32;

/// Random values at the whole places of the plane, smoothly blended between (value noise).
#[derive(Debug, Clone)]
pub(super) struct Lattice(Vec<f32>);

impl Lattice {
    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        Self((0..SIDE * SIDE).map(|_| unit(rng) as f32).collect())
    }

    /// The value at a place, 0 to 1.
    pub(super) fn at(&self, x: f32, y: f32) -> f32 {
        let (left, top) = (x.floor(), y.floor());
        let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
        let (u, v) = (smooth(x - left), smooth(y - top));
        let wrap = |at: f32, step: i32| (at as i32 + step).rem_euclid(SIDE as i32) as usize;
        let (a, b) = (wrap(left, 0), wrap(left, 1));
        let row = |step: i32| {
            let row = wrap(top, step) * SIDE;
            self.0[row + a] * (1.0 - u) + self.0[row + b] * u
        };
        row(0) * (1.0 - v) + row(1) * v
    }

    /// Two octaves at a place in space, 0 to 1.
    pub(super) fn at_place(&self, [x, y, z]: [f32; 3]) -> f32 {
        let (u, v) = (x + 0.61 * z, y - 0.47 * z + 0.31 * x);
        0.65 * self.at(u, v) + 0.35 * self.at(2.1 * u + 7.3, 2.1 * v + 3.7)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn the_field_is_continuous_and_repeats() {
        let lattice = Lattice::random(&mut ChaCha8Rng::seed_from_u64(1));
        for step in -300..300 {
            let (x, y) = (step as f32 * 0.13, step as f32 * -0.29);
            let value = lattice.at(x, y);
            assert!((0.0..=1.0).contains(&value));
            assert!((lattice.at(x + 1e-3, y) - value).abs() < 0.01);
            assert!((lattice.at(x + SIDE as f32, y) - value).abs() < 1e-3);
        }
    }
}
