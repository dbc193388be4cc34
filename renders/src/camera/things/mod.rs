//! From the plain body that a grasp closes on to a thing that people hold.
//!
//! The fingers close on a cylinder, a ball or a disc; what is in a picture is a can, a mug, a
//! football, a hammer, a bulb. The hand stays as it is: parts are added, and shapes changed, where
//! no finger lies.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::solid::{Lathe, tube};
use crate::grasp::{Object, PlacedObject};
use crate::mesh::Mesh;
use crate::random::{between, normal, unit};

type V = Vector3<f64>;

/// A grasp whose largest balls are below this radius in metres is one that picks up small things.
const SMALL: f64 = 0.02;
/// Cylinders from this radius in metres on are vessels, thinner ones handles.
const VESSEL: f64 = 0.024;
/// About the middle of the palm, in the frame of the hand.
const PALM: V = V::new(0.07, 0.0, -0.01);

/// How far a vessel is from being held in the middle, in halves of its length at most: in the palm,
/// and at the finger tips, further from the palm than this in metres.
const OFF_IN_PALM: f64 = 0.35;
const OFF_AT_TIPS: f64 = 0.7;
const AT_TIPS: f64 = 0.075;

/// The parts of a thing, held in a grasp whose bodies have a radius of at most `largest`; each has
/// a material of its own.
pub(super) fn dress(object: &PlacedObject, largest: f64, rng: &mut ChaCha8Rng) -> Vec<Mesh> {
    let place = Isometry3::from_parts(Translation3::from(object.centre), object.turn);
    // Away from the palm, in the thing's own frame.
    let away = place.inverse_transform_vector(&(object.centre - PALM));
    let far = away.norm();
    let away = away.try_normalize(1e-9).unwrap_or_else(V::z);
    let off = if far > AT_TIPS { OFF_AT_TIPS } else { OFF_IN_PALM };
    let mut thing = Thing { place, away, off, parts: Vec::new() };
    match object.object {
        Object::Sphere { radius } if largest < SMALL => thing.small(radius, rng),
        Object::Sphere { radius } => thing.ball(radius, rng),
        Object::Cylinder { radius, length } if length < radius => thing.lid(radius, length, rng),
        Object::Cylinder { radius, length } if radius < VESSEL => thing.tool(radius, length, rng),
        Object::Cylinder { radius, length } => thing.vessel(radius, length, rng),
    }
    thing.parts
}

/// A vessel whose axis is nearer to the way out of the hand than this (cosine) is held at its end.
const AT_END: f64 = 0.6;
/// How far its end is behind the finger tips then, and how long it is, in metres.
const BEHIND_TIPS: [f64; 2] = [0.005, 0.045];
const LENGTH_AT_END: [f64; 2] = [0.06, 0.17];

/// A thing that is put together in its own frame.
struct Thing {
    place: Isometry3<f64>,
    away: V,
    off: f64,
    parts: Vec<Mesh>,
}

impl Thing {
    fn add(&mut self, solid: &Lathe, place: Isometry3<f64>) {
        self.parts.push(solid.mesh(&(self.place * place)));
    }

    fn add_tube(&mut self, path: &[V], radius: f64) {
        self.parts.push(tube(path, radius, &self.place));
    }

    /// A can, a bottle, a mug, a box, a jar: around z.
    fn vessel(&mut self, r: f64, length: f64, rng: &mut ChaCha8Rng) {
        let (half, shift) = if self.away.z.abs() > AT_END {
            let half = 0.5 * between(rng, LENGTH_AT_END);
            (half, upward(self.away.z) * at_height(half - between(rng, BEHIND_TIPS)))
        } else {
            let half = 0.5 * length * between(rng, [0.6, 1.35]);
            (half, at_height(self.off * half * (2.0 * unit(rng) - 1.0)))
        };
        match unit(rng) {
            x if x < 0.3 => {
                let rim = r * between(rng, [0.8, 1.0]);
                let profile =
                    [[0.0, -half], [rim, -half], [r, 0.15 * r - half], [r, half - 0.15 * r], [rim, half]];
                self.add(&Lathe::round(profile.into_iter().chain([[0.0, half]]).collect()), shift);
            }
            x if x < 0.55 => {
                let (neck, shoulder) = (r * between(rng, [0.28, 0.55]), between(rng, [0.3, 1.4]) * r);
                let top = half + shoulder;
                let profile =
                    vec![[0.0, -half], [r, -half], [r, half], [neck, top], [neck, top + r], [0.0, top + r]];
                self.add(&Lathe::round(profile), shift);
                let cap = Lathe::cylinder(neck * 1.2, between(rng, [0.01, 0.03]));
                self.add(&cap, shift * at_height(top + r));
            }
            x if x < 0.8 => {
                let (low, high) = (r * between(rng, [0.8, 1.05]), r * between(rng, [0.95, 1.25]));
                let profile = vec![[0.0, -half], [low, -half], [high, half], [0.9 * high, 0.96 * half]];
                self.add(&Lathe::round(profile), shift);
                if unit(rng) < 0.7 {
                    self.handle(r, half, &shift, rng);
                }
            }
            x if x < 0.9 => {
                let aspect = [between(rng, [0.8, 1.3]) * r, between(rng, [0.7, 1.0]) * r];
                let square = Lathe { aspect, squareness: 1.0, ..Lathe::cylinder(1.0, 2.0 * half) };
                self.add(&square, shift);
            }
            _ => {
                self.add(&Lathe::cylinder(r, 2.0 * half), shift);
                let lid = Lathe::cylinder(r * between(rng, [0.7, 1.1]), between(rng, [0.01, 0.03]));
                self.add(&lid, shift * at_height(half));
            }
        }
    }

    /// A mug's, on the side that the palm is not on.
    fn handle(&mut self, r: f64, half: f64, shift: &Isometry3<f64>, rng: &mut ChaCha8Rng) {
        let angle = libm::atan2(self.away.y, self.away.x) + 1.1 * normal(rng);
        let (sin, cos) = libm::sincos(angle);
        let out = V::new(cos, sin, 0.0);
        let (wide, high) = (between(rng, [0.02, 0.035]), 0.5 * half.min(0.05));
        let bow = |i: i32| {
            let (sin, cos) = libm::sincos((f64::from(i) / 8.0 - 0.5) * std::f64::consts::PI);
            (shift * Point3::from(out * (r + wide * cos) + V::z() * (high * sin))).coords
        };
        let path: Vec<V> = (0..=8).map(bow).collect();
        self.add_tube(&path, between(rng, [0.003, 0.006]));
    }

    /// A ball, a football, a fruit.
    fn ball(&mut self, r: f64, rng: &mut ChaCha8Rng) {
        // It grows away from the palm, and goes on through where the fingers lie.
        let size = match unit(rng) {
            x if x < 0.15 => r * between(rng, [1.5, 2.5]),
            x if x < 0.45 => r * between(rng, [1.0, 1.5]),
            _ => r,
        };
        let centre = Translation3::from(self.away * (size * size - r * r).max(0.0).sqrt());
        if unit(rng) < 0.65 {
            self.add(&Lathe::ball(size), centre.into());
        } else {
            let stretch = between(rng, [1.15, 1.75]);
            let mut long = Lathe::ball(size * 0.95);
            long.profile.iter_mut().for_each(|[_, height]| *height *= stretch);
            self.add(&long, centre * any_turn(rng));
        }
        if unit(rng) < 0.15 {
            let stalk = Lathe::cylinder(0.003, 0.03);
            self.add(&stalk, centre * any_turn(rng) * at_height(size));
        }
    }

    /// A rod with or without a head: a hammer, a knife, a screwdriver, a remote control.
    fn tool(&mut self, r: f64, length: f64, rng: &mut ChaCha8Rng) {
        let half = 0.5 * length * between(rng, [0.7, 1.3]);
        let shift = at_height(0.3 * half * (2.0 * unit(rng) - 1.0));
        // Most heads are on the thumb's side.
        let top = if unit(rng) < 0.8 { 1.0 } else { -1.0 };
        let squareness = if unit(rng) < 0.3 { 1.0 } else { 0.0 };
        let flat = [between(rng, [0.9, 1.3]), between(rng, [0.6, 1.0])];
        self.add(&Lathe { aspect: flat, squareness, ..Lathe::cylinder(r, 2.0 * half) }, shift);
        let end = |far: f64| shift * at_height(top * (half + far));
        match (unit(rng) * 6.0) as u32 {
            0 => {
                let head =
                    [between(rng, [0.02, 0.035]), between(rng, [0.06, 0.12]), between(rng, [0.02, 0.035])];
                self.add(&Lathe::cuboid(head), end(0.01));
            }
            1 => {
                let long = between(rng, [0.06, 0.18]);
                let blade = [between(rng, [0.015, 0.04]), 0.003, long];
                self.add(&Lathe::cuboid(blade), end(0.5 * long));
            }
            2 => {
                let long = between(rng, [0.05, 0.15]);
                self.add(&Lathe::cylinder(between(rng, [0.2, 0.5]) * r, long), end(0.5 * long));
            }
            3 => {
                let wide = between(rng, [0.02, 0.05]);
                let head = Lathe { aspect: [1.0, 0.25], ..Lathe::ball(wide) };
                self.add(&head, end(wide));
            }
            4 => {
                // Scissors and tongs.
                for side in [-1.0, 1.0] {
                    let ring = V::new(side * 0.022, 0.0, top * (half + 0.02));
                    self.add_ring(ring, 0.02, 0.004);
                    let blade = [0.012, 0.003, between(rng, [0.05, 0.1])];
                    self.add(&Lathe::cuboid(blade), shift * at_height(-top * (half + 0.03)));
                }
            }
            _ => {}
        }
    }

    /// A lid, a jar under its lid, a bowl, a knob: the disc lies across z.
    fn lid(&mut self, r: f64, thick: f64, rng: &mut ChaCha8Rng) {
        let far = if self.away.z < 0.0 { -1.0 } else { 1.0 };
        self.add(&Lathe::cylinder(r, thick), Isometry3::identity());
        match unit(rng) {
            x if x < 0.18 => {
                let long = between(rng, [0.03, 0.13]);
                let (near_end, far_end) = (r * between(rng, [0.75, 1.0]), r * between(rng, [0.5, 1.2]));
                let half = 0.5 * long;
                let [low, high] = if far > 0.0 { [near_end, far_end] } else { [far_end, near_end] };
                let profile = vec![[0.0, -half], [low, -half], [high, half], [0.0, half]];
                self.add(&Lathe::round(profile), at_height(far * (0.5 * thick + half)));
            }
            x if x < 0.4 => {
                let rim = Lathe::cylinder(r * between(rng, [0.3, 0.8]), 0.004);
                self.add(&rim, at_height(-far * 0.5 * thick));
            }
            _ => {}
        }
    }

    /// What finger tips pick up: a bulb, a plug, a pen, glasses, a card.
    fn small(&mut self, r: f64, rng: &mut ChaCha8Rng) {
        let lean = V::from_fn(|_, _| normal(rng)) * 0.5;
        let out = (self.away + lean).try_normalize(1e-9).unwrap_or(self.away);
        let turn = UnitQuaternion::rotation_between(&V::z(), &out).unwrap_or_else(UnitQuaternion::identity);
        let along = |far: f64| Isometry3::from_parts(Translation3::from(out * far), turn);
        match (unit(rng) * 10.0) as u32 {
            0 => {
                let (long, wide) = (between(rng, [0.02, 0.05]), between(rng, [0.018, 0.035]));
                self.add(&Lathe::cylinder(r * between(rng, [0.7, 1.2]), long), along(0.3 * long));
                self.add(&Lathe::ball(wide), along(0.8 * long + 0.8 * wide));
            }
            1 => {
                let long = between(rng, [0.09, 0.17]);
                let rod = Lathe::cylinder(r * between(rng, [0.4, 1.0]), long);
                let at = between(rng, [-0.35, 0.45]) * long;
                self.add(&rod, along(at));
                self.add(&Lathe::cylinder(r.min(0.009), 0.3 * long), along(at + 0.4 * long));
            }
            2 | 3 => {
                let size = [between(rng, [0.015, 0.045]), 2.0 * r, between(rng, [0.02, 0.06])];
                self.add(&Lathe::cuboid(size), along(0.35 * size[2]));
                if unit(rng) < 0.4 {
                    self.add(&Lathe::cylinder(0.0025, 0.03), along(0.9 * size[2]));
                }
            }
            4 => {
                let size = [between(rng, [0.04, 0.09]), 0.003, between(rng, [0.04, 0.12])];
                self.add(&Lathe::cuboid(size), along(0.42 * size[2]));
            }
            5 => {
                let (wide, long) = (between(rng, [0.018, 0.028]), between(rng, [0.02, 0.12]));
                self.add(&Lathe::cylinder(0.003, long), along(0.4 * long));
                let frame = turn * Point3::new(1.1 * wide, 0.0, 0.9 * long);
                for side in [-1.0, 1.0] {
                    let ring = frame.coords + turn * V::x() * (side * 1.1 * wide);
                    self.add_ring(ring, wide, between(rng, [0.0015, 0.004]));
                }
                let lens = Lathe { aspect: [1.0, 1.0], ..Lathe::cylinder(wide, 0.002) };
                let place = Isometry3::from_parts(Translation3::from(frame.coords), turn);
                self.add(&lens, place);
            }
            6 => {
                // Scissors by one blade or ring.
                for side in [-1.0, 1.0] {
                    let spread = turn * V::x() * (side * 0.02);
                    let blade = [V::zeros(), out * 0.06 + spread * 0.5, out * 0.12];
                    self.add_tube(&blade, 0.004);
                    self.add_ring(out * -0.03 + spread, 0.018, 0.004);
                }
            }
            7 => {
                // A die, a plug's adapter: as wide as the fingers are apart.
                let size = [2.1 * r, 2.1 * r * between(rng, [0.8, 1.2]), 2.1 * r * between(rng, [0.8, 1.4])];
                self.add(&Lathe::cuboid(size), along(between(rng, [-0.1, 0.35]) * size[2]));
            }
            8 => {
                let tall = between(rng, [0.6, 1.6]);
                self.add(&Lathe { aspect: [1.0, tall], ..Lathe::ball(r) }, along(0.0));
            }
            _ => self.add(&Lathe::cylinder(r, between(rng, [0.01, 0.05])), along(0.0)),
        }
    }

    /// A ring of so many metres around a place, in the plane that its x and z span.
    fn add_ring(&mut self, centre: V, radius: f64, thick: f64) {
        let around = |i: i32| {
            let (sin, cos) = libm::sincos(f64::from(i) / 12.0 * std::f64::consts::TAU);
            centre + V::new(radius * cos, 0.0, radius * sin)
        };
        let path: Vec<V> = (0..=12).map(around).collect();
        self.add_tube(&path, thick);
    }
}

fn at_height(height: f64) -> Isometry3<f64> {
    Isometry3::translation(0.0, 0.0, height)
}

/// Upside down where `z` is negative.
fn upward(z: f64) -> Isometry3<f64> {
    Isometry3::rotation(if z < 0.0 { V::x() * std::f64::consts::PI } else { V::zeros() })
}

fn any_turn(rng: &mut ChaCha8Rng) -> UnitQuaternion<f64> {
    UnitQuaternion::new(V::from_fn(|_, _| 1.5 * normal(rng)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::GraspSet;
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

    #[test]
    fn every_thing_has_parts_near_where_it_is_held() {
        for (number, grasp) in (0..).zip(GraspSet::builtin().iter()) {
            for seed in 0..60 {
                let mut rng = ChaCha8Rng::seed_from_u64(100 * number + seed);
                let object = grasp.object.object(unit(&mut rng));
                let held = PlacedObject::new(object, V::new(0.1, 0.0, -0.04), &V::y());
                let parts = dress(&held, grasp.object.radius[1], &mut rng);
                assert!((1..=8).contains(&parts.len()), "{}: {} parts", grasp.name, parts.len());
                let nearest = parts.iter().flat_map(|part| &part.vertices).map(|corner| {
                    let away = (corner.cast() - held.centre).norm();
                    assert!(away < 0.5, "{}: {away} m", grasp.name);
                    held.distance(&corner.cast()).abs()
                });
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.03, "{}: {nearest} m from where it is held", grasp.name);
            }
        }
    }
}
