//! What the hand holds.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Deserialize;

use crate::mesh::Mesh;

/// Kind of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectKind {
    /// A long cylinder.
    Cylinder,
    /// A flat cylinder.
    Disc,
    /// A ball.
    Sphere,
}

/// The body of an object, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Object {
    /// A cylinder, long (a bottle, a handle) or flat (a lid).
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along the axis.
        length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
}

impl Object {
    /// A name fit for a file name: the kind and its measures in tenths of a millimetre.
    pub fn name(&self) -> String {
        let tenths = |m: f64| (m * 1e4).round() as i64;
        match *self {
            Object::Cylinder { radius, length } => {
                let kind = if length < radius { "disc" } else { "cylinder" };
                format!("{kind}-{}x{}", tenths(radius), tenths(length))
            }
            Object::Sphere { radius } => format!("sphere-{}", tenths(radius)),
        }
    }

    /// Radius in metres.
    pub fn radius(&self) -> f64 {
        match *self {
            Object::Cylinder { radius, .. } | Object::Sphere { radius } => radius,
        }
    }
}

/// An object in its place in the hand frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedObject {
    /// The body; a cylinder's own axis is its z.
    pub object: Object,
    /// The body's centre.
    pub centre: Vector3<f64>,
    /// Turns the body's own axes into the hand's.
    pub turn: UnitQuaternion<f64>,
}

impl PlacedObject {
    /// Places the object with its centre at `centre` and its axis along `axis` (any length but 0).
    pub(crate) fn new(object: Object, centre: Vector3<f64>, axis: &Vector3<f64>) -> PlacedObject {
        // Half a turn: no single shortest rotation, any will do for a body of revolution.
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), axis)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        PlacedObject { object, centre, turn }
    }

    /// Signed distance from a point of the hand frame to the surface in metres, negative inside.
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        let local = self.turn.inverse_transform_vector(&(p - self.centre));
        match self.object {
            Object::Sphere { radius } => local.norm() - radius,
            Object::Cylinder { radius, length } => {
                let out = libm::hypot(local.x, local.y) - radius;
                let over = local.z.abs() - 0.5 * length;
                out.max(over).min(0.0) + libm::hypot(out.max(0.0), over.max(0.0))
            }
        }
    }

    /// The surface as triangles.
    pub(crate) fn mesh(&self) -> Mesh {
        let profile: Vec<(f64, f64)> = match self.object {
            Object::Cylinder { radius, length } => {
                vec![
                    (0.0, -0.5 * length),
                    (radius, -0.5 * length),
                    (radius, 0.5 * length),
                    (0.0, 0.5 * length),
                ]
            }
            Object::Sphere { radius } => {
                let belt = (1..16)
                    .map(|i| (f64::from(i) / 16.0 - 0.5) * std::f64::consts::PI)
                    .map(|a| (radius * libm::cos(a), radius * libm::sin(a)));
                std::iter::once((0.0, -radius)).chain(belt).chain([(0.0, radius)]).collect()
            }
        };
        const SIDES: u32 = 40;
        let mut mesh = Mesh::default();
        for &(out, up) in &profile {
            for side in 0..SIDES {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(side) / f64::from(SIDES));
                let local = Vector3::new(out * cos, out * sin, up);
                let turned = self.turn * local;
                mesh.vertices.push((self.centre + turned).cast());
                mesh.normals.push(turned.try_normalize(1e-12).unwrap_or_else(Vector3::z).cast());
            }
        }
        for ring in 0..profile.len() as u32 - 1 {
            for side in 0..SIDES {
                let next = (side + 1) % SIDES;
                let [a, b] = [ring * SIDES + side, ring * SIDES + next];
                let [c, d] = [a + SIDES, b + SIDES];
                mesh.triangles.push([a, b, d]);
                mesh.triangles.push([a, d, c]);
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(object: Object) -> PlacedObject {
        PlacedObject::new(object, Vector3::new(0.1, -0.2, 0.3), &Vector3::new(0.0, 1.0, 0.0))
    }

    #[test]
    fn the_mesh_lies_on_the_surface_right_side_out() {
        let cylinder = placed(Object::Cylinder { radius: 0.03, length: 0.1 });
        let sphere = placed(Object::Sphere { radius: 0.03 });
        for (body, volume) in [(cylinder, 9e-4 * 0.1), (sphere, 4.0 / 3.0 * 2.7e-5)] {
            let mesh = body.mesh();
            assert!(mesh.is_closed());
            let exact = volume * std::f64::consts::PI;
            assert!((mesh.volume() - exact).abs() < 0.03 * exact);
            for v in &mesh.vertices {
                assert!(body.distance(&v.cast()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn distances_along_and_across_the_axis() {
        let body = placed(Object::Cylinder { radius: 0.03, length: 0.1 });
        let at = |x: f64, y: f64| body.distance(&(body.centre + Vector3::new(x, y, 0.0)));
        assert!((at(0.05, 0.0) - 0.02).abs() < 1e-12);
        assert!((at(0.0, 0.07) - 0.02).abs() < 1e-12);
        assert!((at(0.06, 0.09) - 0.05).abs() < 1e-12);
        assert!((at(0.0, 0.0) + 0.03).abs() < 1e-12);
    }
}
