//! Lids, jars under their lids, tins, bowls, knobs and rolls of tape: the disc lies across z.

use rand_chacha::ChaCha8Rng;

use super::{Lathe, Of, Thing, at_height};
use crate::random::{between, unit};

impl Thing {
    pub(super) fn lid(&mut self, r: f64, thick: f64, rng: &mut ChaCha8Rng) {
        let far = if self.away.z < 0.0 { -1.0 } else { 1.0 };
        let half = 0.5 * thick;
        if unit(rng) < 0.06 {
            let hole = r * between(rng, [0.5, 0.8]);
            let profile = vec![[hole, -half], [r, -half], [r, half], [hole, half], [hole, -half]];
            self.add(Of::Body, &Lathe::round(profile), at_height(0.0));
            return;
        }
        let bevel = if unit(rng) < 0.6 { thick * between(rng, [0.06, 0.35]) } else { 0.0 };
        let edge = half - bevel;
        let profile =
            vec![[0.0, -half], [r - bevel, -half], [r, -edge], [r, edge], [r - bevel, half], [0.0, half]];
        self.add(Of::Body, &Lathe::round(profile), at_height(0.0));
        match unit(rng) {
            // A tin's label or a lid's side.
            x if x < 0.2 => {
                let band = Lathe::cylinder(1.01 * r, thick * between(rng, [0.4, 0.95]));
                self.add(Of::Trim, &band, at_height(0.0));
            }
            // Its face, on one side or on both.
            x if x < 0.45 => {
                let face = Lathe::cylinder((r - bevel) * between(rng, [0.7, 0.99]), 0.5 * thick);
                self.add(Of::Trim, &face, at_height(0.26 * thick));
                if unit(rng) < 0.5 {
                    self.add(Of::Trim, &face, at_height(-0.26 * thick));
                }
            }
            _ => {}
        }
        match unit(rng) {
            x if x < 0.18 => {
                let long = between(rng, [0.03, 0.13]);
                let (near_end, far_end) = (r * between(rng, [0.75, 1.0]), r * between(rng, [0.5, 1.2]));
                let half = 0.5 * long;
                let [low, high] = if far > 0.0 { [near_end, far_end] } else { [far_end, near_end] };
                let profile = vec![[0.0, -half], [low, -half], [high, half], [0.0, half]];
                self.add(Of::Extra, &Lathe::round(profile), at_height(far * (0.5 * thick + half)));
            }
            x if x < 0.35 => {
                let rim = Lathe::cylinder(r * between(rng, [0.3, 0.8]), 0.004);
                self.add(Of::Trim, &rim, at_height(-far * half));
            }
            _ => {}
        }
    }
}
