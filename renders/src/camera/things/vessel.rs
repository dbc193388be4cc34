//! Cans, bottles, mugs, boxes and jars: around z.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Isometry3, Point3};
use rand_chacha::ChaCha8Rng;

use super::{Lathe, Of, Thing, V, at_height, upward};
use crate::random::{between, normal, unit};

/// How far a vessel is from being held in the middle, in halves of its length at most: in the palm,
/// and at the finger tips, further from the palm than this in metres.
const OFF_IN_PALM: f64 = 0.35;
const OFF_AT_TIPS: f64 = 0.7;
const AT_TIPS: f64 = 0.075;
/// A vessel whose axis is nearer to the way out of the hand than this (cosine) is held at its end.
const AT_END: f64 = 0.6;
/// How far its end is behind the finger tips then, and how long it is, in metres.
const BEHIND_TIPS: [f64; 2] = [0.005, 0.045];
const LENGTH_AT_END: [f64; 2] = [0.06, 0.17];
/// Half a mug's height, in its radii.
const MUG: [f64; 2] = [0.75, 1.4];

/// Where a vessel is held.
#[derive(Debug, Clone, Copy)]
struct Hold {
    /// Half the vessel's length in metres, and the vessel's place.
    half: f64,
    place: Isometry3<f64>,
}

impl Thing {
    pub(super) fn vessel(&mut self, r: f64, length: f64, rng: &mut ChaCha8Rng) {
        let half = if self.is_at_end() {
            0.5 * between(rng, LENGTH_AT_END)
        } else {
            0.5 * length * between(rng, [0.6, 1.35])
        };
        match unit(rng) {
            x if x < 0.28 => self.can(r, &self.hold(half, rng), rng),
            x if x < 0.50 => self.bottle(r, &self.hold(half, rng), rng),
            x if x < 0.80 => self.mug(r, &self.hold(r * between(rng, MUG), rng), rng),
            x if x < 0.90 => {
                let hold = self.hold(half, rng);
                let aspect = [between(rng, [0.8, 1.3]) * r, between(rng, [0.7, 1.0]) * r];
                let square = Lathe { aspect, squareness: 1.0, ..Lathe::cylinder(1.0, 2.0 * half) };
                self.add(Of::Body, &square, hold.place);
            }
            _ => {
                let hold = self.hold(half, rng);
                self.add(Of::Body, &Lathe::cylinder(r, 2.0 * half), hold.place);
                let lid = Lathe::cylinder(r * between(rng, [0.7, 1.1]), between(rng, [0.01, 0.03]));
                self.add(Of::Trim, &lid, hold.place * at_height(half));
            }
        }
    }

    fn is_at_end(&self) -> bool {
        self.away.z.abs() > AT_END
    }

    fn hold(&self, half: f64, rng: &mut ChaCha8Rng) -> Hold {
        let place = if self.is_at_end() {
            upward(self.away.z) * at_height(half - between(rng, BEHIND_TIPS))
        } else {
            let off = if self.far > AT_TIPS { OFF_AT_TIPS } else { OFF_IN_PALM };
            at_height(off * half * (2.0 * unit(rng) - 1.0))
        };
        Hold { half, place }
    }

    /// Its ends narrower than its middle, and mostly of bare metal.
    fn can(&mut self, r: f64, hold: &Hold, rng: &mut ChaCha8Rng) {
        let (half, rim) = (hold.half, r * between(rng, [0.8, 1.0]));
        let shoulder = half - between(rng, [0.05, 0.2]) * r;
        let ends = if unit(rng) < 0.7 { Of::Trim } else { Of::Body };
        self.add(Of::Body, &Lathe::round(vec![[r, -shoulder], [r, shoulder]]), hold.place);
        for end in [1.0, -1.0] {
            // The lid lies a little below the rim.
            let inner = rim - 0.1 * r;
            let profile =
                vec![[r, shoulder], [rim, half], [inner, half], [inner, half - 0.004], [0.0, half - 0.004]];
            self.add(ends, &Lathe::round(profile), hold.place * upward(end));
        }
    }

    fn bottle(&mut self, r: f64, hold: &Hold, rng: &mut ChaCha8Rng) {
        let half = hold.half;
        let (neck, shoulder) = (r * between(rng, [0.28, 0.55]), between(rng, [0.3, 1.4]) * r);
        let top = half + shoulder;
        let is_round = unit(rng) < 0.5;
        let mut profile = vec![[0.0, -half], [r, -half], [r, half]];
        if is_round {
            profile.extend((1..5).map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i) / 5.0 * FRAC_PI_2);
                [neck + (r - neck) * cos, half + shoulder * sin]
            }));
        }
        profile.extend([[neck, top], [neck, top + r], [0.0, top + r]]);
        self.add(Of::Body, &Lathe::round(profile), hold.place);
        let cap = Lathe::cylinder(neck * 1.2, between(rng, [0.01, 0.03]));
        self.add(Of::Trim, &cap, hold.place * at_height(top + r));
        if unit(rng) < 0.5 {
            let label = Lathe::cylinder(1.01 * r, half * between(rng, [0.5, 1.6]));
            self.add(Of::Extra, &label, hold.place * at_height(half * between(rng, [-0.2, 0.2])));
        }
    }

    /// A mug, a cup or a glass: open above, with a handle or without.
    fn mug(&mut self, r: f64, hold: &Hold, rng: &mut ChaCha8Rng) {
        let half = hold.half;
        let (low, high) = (r * between(rng, [0.75, 1.03]), r * between(rng, [0.97, 1.25]));
        // How much of its height a cup's round bottom takes; a mug's has none.
        let round = if unit(rng) < 0.35 { between(rng, [0.3, 0.9]) } else { 0.0 };
        let mut outside = vec![[0.0, -half]];
        if round > 0.0 {
            let foot = low * between(rng, [0.3, 0.6]);
            outside.extend((0..6).map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i) / 6.0 * FRAC_PI_2);
                [foot + (low - foot) * sin, -half + 2.0 * half * round * (1.0 - cos)]
            }));
            outside.push([low, -half + 2.0 * half * round]);
        } else {
            outside.push([low, -half]);
        }
        outside.push([high, half]);
        let wall = between(rng, [0.002, 0.005]);
        let inside = outside.iter().rev().map(|[radius, height]| {
            [(radius - wall).max(0.0), if *height < half { height + 2.0 * wall } else { *height }]
        });
        let profile = outside.iter().copied().chain(inside).collect();
        self.add(Of::Body, &Lathe::round(profile), hold.place);
        if unit(rng) < 0.8 {
            self.handle(0.5 * (low + high), hold, rng);
        }
    }

    /// A mug's, on the side that the palm is not on.
    fn handle(&mut self, r: f64, hold: &Hold, rng: &mut ChaCha8Rng) {
        let angle = if self.is_at_end() {
            TAU * unit(rng)
        } else {
            libm::atan2(self.away.y, self.away.x) + 1.1 * normal(rng)
        };
        let (sin, cos) = libm::sincos(angle);
        let out = V::new(cos, sin, 0.0);
        let (wide, high) = (between(rng, [0.018, 0.036]), hold.half * between(rng, [0.4, 0.8]));
        let middle = hold.half * between(rng, [-0.1, 0.2]);
        // From half an ellipse to nearly a rectangle.
        let power = between(rng, [0.4, 1.0]);
        let bow = |i: i32| {
            let (sin, cos) = libm::sincos((f64::from(i) / 12.0 - 0.5) * PI);
            let far = r - 0.003 + wide * libm::pow(cos.max(0.0), power);
            let up = middle + high * libm::copysign(libm::pow(sin.abs(), power), sin);
            (hold.place * Point3::from(out * far + V::z() * up)).coords
        };
        let path: Vec<V> = (0..=12).map(bow).collect();
        let of = if unit(rng) < 0.85 { Of::Body } else { Of::Trim };
        self.add_tube(of, &path, between(rng, [0.0035, 0.008]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::things::dress;
    use crate::grasp::{Object, PlacedObject};
    use rand::SeedableRng;

    #[test]
    fn a_vessel_that_is_held_by_its_end_stands_out_of_the_hand() {
        for seed in 0..60 {
            for axis in [V::x(), -V::x()] {
                let body = Object::Cylinder { radius: 0.035, length: 0.05 };
                let held = PlacedObject::new(body, V::new(0.18, 0.0, -0.02), &axis);
                let parts = dress(&held, 0.05, &mut ChaCha8Rng::seed_from_u64(seed));
                let along = parts
                    .iter()
                    .flat_map(|part| &part.vertices)
                    .map(|corner| (corner.cast() - held.centre).x)
                    .fold([0.0f64; 2], |[low, high], x| [low.min(x), high.max(x)]);
                assert!(along[0] > -1.2 * BEHIND_TIPS[1] && along[1] > 0.01, "{seed}: {along:?}");
            }
        }
    }
}
