//! Rods with or without a head: hammers, knives, screwdrivers, remote controls, scissors.

use nalgebra::{Isometry3, Point3};
use rand_chacha::ChaCha8Rng;

use super::{Lathe, Of, Thing, V, at_height};
use crate::random::{between, unit};

/// Of the eight kinds of tools.
const SCISSORS: u32 = 4;
const REMOTE_CONTROL: u32 = 5;

impl Thing {
    pub(super) fn tool(&mut self, r: f64, length: f64, rng: &mut ChaCha8Rng) {
        let half = 0.5 * length * between(rng, [0.7, 1.3]);
        let shift = at_height(0.3 * half * (2.0 * unit(rng) - 1.0));
        // Most heads are on the thumb's side.
        let top = if unit(rng) < 0.8 { 1.0 } else { -1.0 };
        let end = |far: f64| shift * at_height(top * (half + far));
        let kind = (unit(rng) * 8.0) as u32;
        if kind == SCISSORS {
            return self.scissors(r, half, top, &shift, rng);
        }
        let is_square = unit(rng) < if kind == REMOTE_CONTROL { 1.0 } else { 0.25 };
        let flat = match kind {
            REMOTE_CONTROL => [between(rng, [1.0, 1.7]), between(rng, [0.35, 0.8])],
            _ => [between(rng, [0.9, 1.3]), between(rng, [0.6, 1.0])],
        };
        let squareness = if is_square { 1.0 } else { 0.0 };
        self.add(Of::Body, &Lathe { aspect: flat, squareness, ..Lathe::cylinder(r, 2.0 * half) }, shift);
        match kind {
            0 => {
                let head =
                    [between(rng, [0.02, 0.035]), between(rng, [0.06, 0.12]), between(rng, [0.02, 0.035])];
                self.add(Of::Trim, &Lathe::cuboid(head), end(0.01));
            }
            1 => {
                let long = between(rng, [0.06, 0.18]);
                let blade = [between(rng, [0.015, 0.04]), 0.003, long];
                self.add(Of::Trim, &Lathe::cuboid(blade), end(0.5 * long));
            }
            2 => {
                let long = between(rng, [0.05, 0.15]);
                self.add(Of::Trim, &Lathe::cylinder(between(rng, [0.2, 0.5]) * r, long), end(0.5 * long));
            }
            3 => {
                let wide = between(rng, [0.02, 0.05]);
                let head = Lathe { aspect: [1.0, 0.25], ..Lathe::ball(wide) };
                self.add(Of::Trim, &head, end(wide));
            }
            REMOTE_CONTROL => {
                // Keys, or a display.
                let (wide, long) = (1.6 * flat[0] * r, half * between(rng, [0.4, 1.4]));
                let front = Lathe::cuboid([wide, 0.002, long]);
                let side = if unit(rng) < 0.5 { 1.0 } else { -1.0 };
                let at = Isometry3::translation(0.0, side * flat[1] * r, 0.2 * half);
                self.add(Of::Trim, &front, shift * at);
            }
            6 => {
                // A marker's cap, a torch's head.
                let (wide, long) = (r * between(rng, [1.02, 1.5]), between(rng, [0.02, 0.06]));
                self.add(Of::Trim, &Lathe { aspect: flat, ..Lathe::cylinder(wide, long) }, end(0.0));
            }
            _ => {}
        }
    }

    /// Scissors and tongs, by their rings or by their closed blades.
    fn scissors(&mut self, r: f64, half: f64, top: f64, shift: &Isometry3<f64>, rng: &mut ChaCha8Rng) {
        let ring = between(rng, [0.014, 0.024]);
        let (open, thick) = (between(rng, [0.0, 0.012]), between(rng, [0.003, 0.006]));
        let long = between(rng, [0.05, 0.1]);
        for side in [-1.0, 1.0] {
            let centre = V::new(side * (ring + open), 0.0, top * (half + ring));
            self.add_ring(
                Of::Body,
                &(shift * Isometry3::translation(centre.x, 0.0, centre.z)),
                [ring; 2],
                thick,
            );
            let place = |x: f64, z: f64| (shift * Point3::new(side * x, 0.0, top * z)).coords;
            self.add_tube(Of::Body, &[place(0.6 * ring, half), place(0.3 * r, 0.3 * half)], 1.5 * thick);
            let blade = [0.3 * r + 0.006, 0.003, long + 1.3 * half];
            let at = Isometry3::translation(side * 0.004, 0.0, top * (0.3 * half - 0.5 * blade[2]));
            self.add(Of::Trim, &Lathe::cuboid(blade), shift * at);
        }
    }
}
