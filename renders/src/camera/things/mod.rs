//! From the plain body that a grasp closes on to a thing that people hold.
//!
//! The fingers close on a cylinder, a ball or a disc; what is in a picture is a can, a mug, a
//! football, a hammer, a bulb. The hand stays as it is: parts are added, and shapes changed, where
//! no finger lies.

mod ball;
mod lid;
mod small;
pub(super) mod solid;
mod tool;
mod vessel;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use solid::{Lathe, tube};

use crate::grasp::{Object, PlacedObject};
use crate::mesh::Mesh;
use crate::random::normal;

type V = Vector3<f64>;

/// A grasp whose largest balls are below this radius in metres is one that picks up small things.
const SMALL: f64 = 0.02;
/// A grasp whose largest cylinders are below this radius in metres is one of handles, not vessels.
const HANDLE: f64 = 0.024;
/// About the middle of the palm, in the frame of the hand.
const PALM: V = V::new(0.07, 0.0, -0.01);

/// The parts of a thing, held in a grasp whose bodies have a radius of at most `largest`, joined by
/// what they are made of: each mesh has a material of its own.
pub(super) fn dress(object: &PlacedObject, largest: f64, rng: &mut ChaCha8Rng) -> Vec<Mesh> {
    let place = Isometry3::from_parts(Translation3::from(object.centre), object.turn);
    // Away from the palm, in the thing's own frame.
    let away = place.inverse_transform_vector(&(object.centre - PALM));
    let far = away.norm();
    let away = away.try_normalize(1e-9).unwrap_or_else(V::z);
    let mut thing = Thing { place, away, far, parts: Default::default() };
    match object.object {
        Object::Sphere { radius } if largest < SMALL => thing.small(radius, rng),
        Object::Sphere { radius } => thing.ball(radius, rng),
        Object::Cylinder { radius, length } if length < radius => thing.lid(radius, length, rng),
        Object::Cylinder { radius, length } if largest < HANDLE => thing.tool(radius, length, rng),
        Object::Cylinder { radius, length } => thing.vessel(radius, length, rng),
    }
    thing.parts.into_iter().filter(|part| !part.triangles.is_empty()).collect()
}

/// What a part of a thing is made of: what is made of the same looks the same.
#[derive(Debug, Clone, Copy)]
enum Of {
    Body,
    Trim,
    Extra,
}

/// A thing that is put together in its own frame.
struct Thing {
    place: Isometry3<f64>,
    /// Away from the palm, a unit vector, and how far from it the thing is, in metres.
    away: V,
    far: f64,
    /// By what they are made of.
    parts: [Mesh; 3],
}

impl Thing {
    fn add(&mut self, of: Of, solid: &Lathe, place: impl Into<Isometry3<f64>>) {
        self.parts[of as usize].append(&solid.mesh(&(self.place * place.into())));
    }

    fn add_tube(&mut self, of: Of, path: &[V], radius: f64) {
        self.parts[of as usize].append(&tube(path, radius, &self.place));
    }

    /// A closed ring around the origin of `place`, in its xz plane, of these radii along x and z.
    fn add_ring(&mut self, of: Of, place: &Isometry3<f64>, [x, z]: [f64; 2], thick: f64) {
        let around = |i: i32| {
            let (sin, cos) = libm::sincos(f64::from(i) / 12.0 * std::f64::consts::TAU);
            (place * Point3::new(x * cos, 0.0, z * sin)).coords
        };
        let path: Vec<V> = (0..=12).map(around).collect();
        self.add_tube(of, &path, thick);
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
    use crate::random::unit;
    use rand::SeedableRng;

    /// Points along the edges of a mesh's triangles.
    fn points(mesh: &Mesh) -> Vec<V> {
        let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let ends = edges.map(|edge| edge.map(|corner| mesh.vertices[corner as usize].cast()));
        ends.flat_map(|[from, to]: [V; 2]| (0..=8).map(move |i| from.lerp(&to, f64::from(i) / 8.0))).collect()
    }

    #[test]
    fn every_thing_has_parts_near_where_it_is_held() {
        for (number, grasp) in (0..).zip(GraspSet::builtin().iter()) {
            for seed in 0..60 {
                let mut rng = ChaCha8Rng::seed_from_u64(100 * number + seed);
                let object = grasp.object.object(unit(&mut rng));
                let held = PlacedObject::new(object, V::new(0.1, 0.0, -0.04), &V::y());
                let parts = dress(&held, grasp.object.radius[1], &mut rng);
                assert!((1..=3).contains(&parts.len()), "{}: {} parts", grasp.name, parts.len());
                let nearest = parts.iter().flat_map(points).map(|point| {
                    let away = (point - held.centre).norm();
                    assert!(away < 0.5, "{}: {away} m", grasp.name);
                    held.distance(&point).abs()
                });
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.03, "{}: {nearest} m from where it is held", grasp.name);
            }
        }
    }
}
