//! Balls, footballs and fruits.

use nalgebra::Translation3;
use rand_chacha::ChaCha8Rng;

use super::{Lathe, Of, Thing, any_turn, at_height};
use crate::random::{between, unit};

impl Thing {
    pub(super) fn ball(&mut self, r: f64, rng: &mut ChaCha8Rng) {
        // It grows away from the palm, and goes on through where the fingers lie.
        let size = match unit(rng) {
            x if x < 0.15 => r * between(rng, [1.5, 2.5]),
            x if x < 0.45 => r * between(rng, [1.0, 1.5]),
            _ => r,
        };
        let centre = Translation3::from(self.away * (size * size - r * r).max(0.0).sqrt());
        match unit(rng) {
            x if x < 0.7 => self.add(Of::Body, &Lathe::ball(size), centre),
            x if x < 0.85 => {
                let stretch = between(rng, [1.15, 1.5]);
                let mut long = Lathe::ball(size * 0.95);
                long.profile.iter_mut().for_each(|[_, height]| *height *= stretch);
                self.add(Of::Body, &long, centre * any_turn(rng));
            }
            _ => self.add(Of::Body, &football(size, between(rng, [1.4, 1.9])), centre * any_turn(rng)),
        }
        if unit(rng) < 0.15 {
            let stalk = Lathe::cylinder(0.003, 0.03);
            self.add(Of::Trim, &stalk, centre * any_turn(rng) * at_height(size));
        }
    }
}

/// Pointed at both ends, so many times as long as it is wide.
fn football(radius: f64, stretch: f64) -> Lathe {
    let at = |ring: i32| {
        let height = f64::from(ring) / 8.0;
        [radius * (1.0 - height * height), radius * stretch * height]
    };
    Lathe::round((-8..=8).map(at).collect())
}
