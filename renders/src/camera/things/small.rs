//! What finger tips pick up: bulbs, plugs, pens, glasses, cards.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use rand_chacha::ChaCha8Rng;

use super::{Lathe, Of, Thing, V, at_height};
use crate::random::{between, normal, unit};

impl Thing {
    pub(super) fn small(&mut self, r: f64, rng: &mut ChaCha8Rng) {
        let lean = V::from_fn(|_, _| normal(rng)) * 0.5;
        let out = (self.away + lean).try_normalize(1e-9).unwrap_or(self.away);
        let turn = turned_to(&V::z(), &out) * UnitQuaternion::new(V::z() * (TAU * unit(rng)));
        // So far out of the fingers, along z.
        let along = |far: f64| Isometry3::from_parts(Translation3::from(out * far), turn);
        match unit(rng) {
            x if x < 0.14 => self.bulb(r, &along(0.0), rng),
            x if x < 0.28 => self.pen(r, &along(0.0), rng),
            x if x < 0.40 => {
                let size = [between(rng, [0.015, 0.045]), 2.0 * r, between(rng, [0.02, 0.06])];
                self.plug(size, &along(0.35 * size[2]), rng);
            }
            // A die, a plug's adapter: as wide as the fingers are apart.
            x if x < 0.52 => {
                let size = [2.1 * r, 2.1 * r * between(rng, [0.8, 1.2]), 2.1 * r * between(rng, [0.8, 1.4])];
                self.plug(size, &along(between(rng, [-0.1, 0.35]) * size[2]), rng);
            }
            x if x < 0.60 => {
                let size = [between(rng, [0.04, 0.09]), 0.003, between(rng, [0.04, 0.12])];
                self.add(Of::Body, &Lathe::cuboid(size), along(0.42 * size[2]));
            }
            x if x < 0.74 => self.glasses(&out, rng),
            x if x < 0.83 => {
                // Scissors by one blade or ring.
                for side in [-1.0, 1.0] {
                    let spread = turn * V::x() * (side * 0.02);
                    let blade = [V::zeros(), out * 0.06 + spread * 0.5, out * 0.12];
                    self.add_tube(Of::Trim, &blade, 0.004);
                    let ring = Translation3::from(out * -0.03 + spread) * turn;
                    self.add_ring(Of::Body, &ring, [0.018; 2], 0.004);
                }
            }
            x if x < 0.91 => {
                let tall = between(rng, [0.6, 1.6]);
                self.add(Of::Body, &Lathe { aspect: [1.0, tall], ..Lathe::ball(r) }, along(0.0));
            }
            _ => self.add(Of::Body, &Lathe::cylinder(r, between(rng, [0.01, 0.05])), along(0.0)),
        }
    }

    /// By its base: a pear, a reflector or a bent tube above it.
    fn bulb(&mut self, r: f64, place: &Isometry3<f64>, rng: &mut ChaCha8Rng) {
        let (base, long) = (r.clamp(0.008, 0.015), between(rng, [0.02, 0.05]));
        // The fingers hold the base, or the neck above it.
        let top = long * between(rng, [0.2, 0.8]);
        self.add(Of::Trim, &Lathe::cylinder(base, long), place * at_height(top - 0.5 * long));
        let (wide, high) = (between(rng, [0.018, 0.034]), between(rng, [0.6, 1.3]));
        match unit(rng) {
            x if x < 0.6 => {
                // From the neck to the fullest part and over it.
                let neck = high * wide;
                let mut profile = vec![[base, top]];
                profile.extend((1..6).map(|i| {
                    let share = f64::from(i) / 6.0;
                    let full = 0.5 - 0.5 * libm::cos(share * std::f64::consts::PI);
                    [base + (wide - base) * full, top + neck * share]
                }));
                profile.extend((0..=6).map(|i| {
                    let (sin, cos) = libm::sincos(f64::from(i) / 6.0 * FRAC_PI_2);
                    [wide * cos.max(0.0), top + neck + wide * sin]
                }));
                self.add(Of::Body, &Lathe::round(profile), *place);
            }
            x if x < 0.8 => {
                let face = top + 1.6 * high * wide;
                let profile =
                    vec![[base, top], [wide, face], [wide, face + 0.004], [0.9 * wide, face + 0.006]];
                self.add(Of::Body, &Lathe::round(profile), *place);
                self.add(Of::Extra, &Lathe::cylinder(0.9 * wide, 0.006), place * at_height(face + 0.003));
            }
            _ => {
                let winding = |i: i32| {
                    let (sin, cos) = libm::sincos(f64::from(i) / 10.0 * TAU);
                    let up = top + 0.005 + 0.001 * f64::from(i);
                    (place * Point3::new(0.8 * wide * cos, 0.8 * wide * sin, up)).coords
                };
                let path: Vec<V> = (0..=40).map(winding).collect();
                self.add_tube(Of::Body, &path, 0.0045);
            }
        }
    }

    /// A pen or a marker, with a cap or without.
    fn pen(&mut self, r: f64, place: &Isometry3<f64>, rng: &mut ChaCha8Rng) {
        let (long, thick) = (between(rng, [0.09, 0.17]), r.min(0.013) * between(rng, [0.5, 1.0]));
        let at = between(rng, [-0.35, 0.45]) * long;
        let aspect = [1.0, between(rng, [0.55, 1.0])];
        self.add(Of::Body, &Lathe { aspect, ..Lathe::cylinder(thick, long) }, place * at_height(at));
        let cap = Lathe { aspect, ..Lathe::cylinder(1.1 * thick, between(rng, [0.2, 0.4]) * long) };
        let end = if unit(rng) < 0.6 { 0.38 } else { -0.38 };
        self.add(Of::Trim, &cap, place * at_height(at + end * long));
        if unit(rng) < 0.4 {
            let tip = Lathe::round(vec![[0.8 * thick, 0.0], [0.3 * thick, 0.012], [0.0, 0.016]]);
            self.add(Of::Extra, &tip, place * at_height(at + 0.5 * long));
        }
    }

    /// A box with pins on one side and perhaps a cable, or with neither.
    fn plug(&mut self, size: [f64; 3], place: &Isometry3<f64>, rng: &mut ChaCha8Rng) {
        let squareness = if unit(rng) < 0.7 { 1.0 } else { between(rng, [0.0, 0.8]) };
        self.add(Of::Body, &Lathe { squareness, ..Lathe::cuboid(size) }, *place);
        if unit(rng) < 0.6 {
            let pins = if unit(rng) < 0.6 { 2 } else { 3 };
            let (thick, long) = (between(rng, [0.0018, 0.003]), between(rng, [0.012, 0.022]));
            for pin in 0..pins {
                let (sin, cos) = libm::sincos(f64::from(pin) / f64::from(pins) * TAU);
                let at =
                    Translation3::new(0.28 * size[0] * cos, 0.28 * size[1] * sin, 0.5 * (size[2] + long));
                self.add(Of::Trim, &Lathe::cylinder(thick, long), place * at);
            }
        }
        if unit(rng) < 0.3 {
            let side = V::from_fn(|_, _| 0.03 * normal(rng));
            let back = |far: f64, bend: f64| (place * Point3::from(V::z() * -far + side * bend)).coords;
            let path: Vec<V> =
                (0..6).map(|i| f64::from(i) / 5.0).map(|t| back(0.4 * size[2] + 0.1 * t, t * t)).collect();
            self.add_tube(Of::Extra, &path, between(rng, [0.0015, 0.003]));
        }
    }

    /// Glasses, by a rim, the bridge or a temple; `out` points out of the fingers.
    fn glasses(&mut self, out: &V, rng: &mut ChaCha8Rng) {
        // In their own frame x goes across, z up and y along the temples.
        let (wide, thick) = (between(rng, [0.018, 0.027]), between(rng, [0.0012, 0.0035]));
        let corner = 2.15 * wide;
        let by = unit(rng);
        let is_by_temple = by >= 0.6;
        let held = match by {
            x if x < 0.4 => V::new(corner, 0.0, 0.0),
            x if x < 0.6 => V::new(0.0, 0.0, 0.2 * wide),
            _ => V::new(corner, between(rng, [0.03, 0.11]), 0.0),
        };
        let towards = V::new(0.0, 0.02, 0.001) - held;
        let towards = towards.try_normalize(1e-9).unwrap_or_else(V::z);
        let roll = UnitQuaternion::new(out * (TAU * unit(rng)));
        let turn = roll * turned_to(&towards, out);
        let place = Translation3::from(turn * -held) * turn;
        let tall = between(rng, [0.6, 1.0]);
        let is_dark = unit(rng) < 0.6;
        for side in [-1.0, 1.0] {
            let middle = place * Translation3::new(side * 1.12 * wide, 0.0, 0.0);
            self.add_ring(Of::Body, &middle, [wide, tall * wide], thick);
            if is_dark {
                let lens = Lathe { aspect: [1.0, tall], ..Lathe::cylinder(wide, 0.001) };
                // The disc's axis goes along the temples.
                let upright = UnitQuaternion::new(V::x() * FRAC_PI_2);
                self.add(Of::Trim, &lens, middle * upright);
            }
            // The temple that is held is open.
            let is_folded = unit(rng) < 0.4 && !(is_by_temple && side > 0.0);
            let end = if is_folded {
                V::new(-side * corner, 0.012, -0.01)
            } else {
                V::new(side * corner, 0.13, -0.01)
            };
            let hinge = V::new(side * corner, 0.004, 0.4 * tall * wide);
            let path = [hinge, end].map(|at| (place * Point3::from(at)).coords);
            self.add_tube(Of::Body, &path, thick.max(0.0016));
        }
        let bridge = [-0.15, 0.15].map(|x| (place * Point3::new(x * wide, 0.0, 0.3 * wide)).coords);
        self.add_tube(Of::Body, &bridge, thick);
    }
}

/// A turn that takes one unit vector to another.
fn turned_to(from: &V, to: &V) -> UnitQuaternion<f64> {
    // Half a turn has no single axis: any across will do.
    UnitQuaternion::rotation_between(from, to)
        .unwrap_or_else(|| UnitQuaternion::new(V::x() * std::f64::consts::PI))
}
