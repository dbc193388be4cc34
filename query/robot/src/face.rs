//! How near a palm's face, a flat disc, comes to an object before both touch.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::Shape;

/// Planes between face and object are tried up to so steep against the face, as the tangent of the
/// angle: at 84 degrees the object is beside the face rather than before it.
const STEEPEST: f64 = 10.0;
/// How often the golden section shortens the range of planes: to a part in ten million.
const ROUNDS: u32 = 40;
/// The golden section of 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A palm's face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Its middle, in the world, in metres.
    pub(super) middle: Point3<f64>,
    /// How it is turned there: its z is the direction in which it moves.
    pub(super) turned: UnitQuaternion<f64>,
    /// In metres.
    pub(super) radius: f64,
}

impl Face {
    /// How far it moves along its z before it touches the object, in metres; negative where it has
    /// to go back.
    ///
    /// Two convex bodies are apart where a plane is between them. Of the planes whose normal is
    /// `(x, y, 1)` in the face's frame each lets the face move so far; the one that lets it move
    /// farthest says how far it can. That distance is concave in x and y, so that the golden
    /// section finds its greatest value, in one direction within the other.
    pub(super) fn room(&self, shape: &Shape, world_from_object: &Isometry3<f64>) -> f64 {
        let face_from_object = self.turned.inverse() * world_from_object.rotation;
        let object = self
            .turned
            .inverse_transform_vector(&(world_from_object.translation.vector - self.middle.coords));
        let along = |x: f64, y: f64| {
            let normal = Vector3::new(x, y, 1.0);
            let length = normal.norm();
            let toward_face = face_from_object.inverse_transform_vector(&(-normal / length));
            normal.dot(&object) - length * shape.reach(&toward_face) - self.radius * x.hypot(y)
        };
        let farthest = greatest(|x| greatest(|y| along(x, y)));
        // What the face meets flat lies at a corner of the function, which is met exactly.
        farthest.max(along(0.0, 0.0))
    }
}

/// The greatest value of a concave function within what is not too steep, by the golden section.
fn greatest(function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-STEEPEST, STEEPEST);
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut left, mut right] = inner(low, high);
    let (mut at_left, mut at_right) = (function(left), function(right));
    for _ in 0..ROUNDS {
        if at_left < at_right {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = function(right);
        } else {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = function(left);
        }
    }
    at_left.max(at_right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By trying: how far points all over the face move before the first of them is inside.
    fn tried(face: &Face, shape: &Shape, world_from_object: &Isometry3<f64>) -> f64 {
        let object_from_face =
            world_from_object.inverse() * Isometry3::from_parts(face.middle.into(), face.turned);
        let mut least = f64::INFINITY;
        for ring in 0..=20 {
            for spoke in 0..72 {
                let radius = face.radius * f64::from(ring) / 20.0;
                let (sin, cos) = (f64::from(spoke) * 5.0).to_radians().sin_cos();
                let mut moved = -0.3;
                while moved < 0.3_f64.min(least)
                    && shape.distance(&(object_from_face * Point3::new(radius * cos, radius * sin, moved)))
                        > 0.0
                {
                    moved += 5e-4;
                }
                least = least.min(moved);
            }
        }
        least
    }

    #[test]
    fn a_face_moves_until_its_nearest_part_touches() {
        let shapes = [
            Shape::Cylinder { radius: 0.035, height: 0.16 },
            Shape::Box { size: [0.16, 0.06, 0.10] },
            Shape::Sphere { radius: 0.04 },
        ];
        let turns = [[0.0, 0.0, 0.0], [0.0, 1.2, 0.0], [0.4, 1.0, -0.3], [2.0, -0.7, 0.9]];
        for shape in shapes {
            for [roll, pitch, yaw] in turns {
                for beside in [[0.0, 0.0], [0.03, -0.02]] {
                    let turned = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                    let object = Isometry3::from_parts(
                        Vector3::new(0.5, -0.2, 0.3).into(),
                        UnitQuaternion::from_euler_angles(0.1, -0.2, 0.7),
                    );
                    let middle =
                        object.translation.vector + turned * Vector3::new(beside[0], beside[1], -0.05);
                    let face = Face { middle: middle.into(), turned, radius: 0.0445 };
                    let (found, tried) = (face.room(&shape, &object), tried(&face, &shape, &object));
                    // Between the tried points the object may be a little nearer.
                    assert!(found < tried + 1e-6 && tried - found < 3e-3, "{shape:?} {found} {tried}");
                }
            }
        }
    }

    #[test]
    fn a_bottle_that_is_met_flat_is_as_far_as_its_side() {
        let shape = Shape::Cylinder { radius: 0.035, height: 0.16 };
        let turned = super::super::ApproachSide::Side.turned();
        let face = Face { middle: Point3::new(-0.1, 0.0, 0.02), turned, radius: 0.0445 };
        let room = face.room(&shape, &Isometry3::identity());
        assert!((room - 0.065).abs() < 1e-9, "{room}");
        // Tilted by 30 degrees, its rim is nearer by the sine of that.
        let tilted = turned * UnitQuaternion::new(Vector3::y() * 30.0_f64.to_radians());
        let approach = tilted * Vector3::z();
        let face = Face { middle: (-0.1 * approach).into(), turned: tilted, radius: 0.0445 };
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let room = face.room(&shape, &Isometry3::identity());
        assert!((room - (0.1 - (0.035 + 0.0445 * sin) / cos)).abs() < 1e-6, "{room}");
    }
}
