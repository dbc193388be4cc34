//! Meshes of things: solids turned on a lathe, squared or flattened, and bent tubes.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::mesh::Mesh;

/// Corners around an axis.
const SIDES: u32 = 28;
/// Corners around a tube.
const TUBE_SIDES: u32 = 10;

/// A solid around the z axis.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::camera) struct Lathe {
    /// Radius and height in metres, from one end to the other.
    pub(in crate::camera) profile: Vec<[f64; 2]>,
    /// Factors of the radius along x and y.
    pub(in crate::camera) aspect: [f64; 2],
    /// 0 is round, 1 is square.
    pub(in crate::camera) squareness: f64,
}

impl Lathe {
    /// A cylinder of a radius and a length, its middle at the origin.
    pub(in crate::camera) fn cylinder(radius: f64, length: f64) -> Self {
        let half = 0.5 * length;
        Self::round(vec![[0.0, -half], [radius, -half], [radius, half], [0.0, half]])
    }

    /// A ball around the origin.
    pub(in crate::camera) fn ball(radius: f64) -> Self {
        const RINGS: i32 = 12;
        let at = |ring: i32| {
            let (sin, cos) = libm::sincos((f64::from(ring) / f64::from(RINGS) - 0.5) * std::f64::consts::PI);
            [radius * cos.max(0.0), radius * sin]
        };
        Self::round((0..=RINGS).map(at).collect())
    }

    /// A box of so many metres along x, y and z around the origin.
    pub(in crate::camera) fn cuboid([x, y, z]: [f64; 3]) -> Self {
        Self { aspect: [0.5 * x, 0.5 * y], squareness: 1.0, ..Self::cylinder(1.0, z) }
    }

    /// A body of revolution.
    pub(in crate::camera) fn round(profile: Vec<[f64; 2]>) -> Self {
        Self { profile, aspect: [1.0; 2], squareness: 0.0 }
    }

    /// Its triangles where `place` puts it.
    pub(in crate::camera) fn mesh(&self, place: &Isometry3<f64>) -> Mesh {
        let rings = self.profile.iter().map(|&[radius, height]| {
            (0..SIDES).map(move |side| {
                let angle = std::f64::consts::TAU * (f64::from(side) + 0.5) / f64::from(SIDES);
                let (sin, cos) = libm::sincos(angle);
                // From the circle towards the square around it.
                let out = 1.0 / (1.0 - self.squareness * (1.0 - cos.abs().max(sin.abs())));
                let [x, y] = [cos * out * self.aspect[0], sin * out * self.aspect[1]];
                place * Point3::new(radius * x, radius * y, height)
            })
        });
        rings_mesh(rings.flatten().collect(), SIDES)
    }
}

/// A tube along a path of at least two points, its ends open.
pub(super) fn tube(path: &[Vector3<f64>], radius: f64, place: &Isometry3<f64>) -> Mesh {
    let mut vertices = Vec::with_capacity(path.len() * TUBE_SIDES as usize);
    for (at, point) in path.iter().enumerate() {
        let before = path[at.saturating_sub(1)];
        let after = path[(at + 1).min(path.len() - 1)];
        let along = (after - before).try_normalize(1e-12).unwrap_or_else(Vector3::z);
        let away = if along.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let u = along.cross(&away).normalize();
        let v = along.cross(&u);
        for side in 0..TUBE_SIDES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(side) / f64::from(TUBE_SIDES));
            vertices.push(place * Point3::from(point + (u * cos + v * sin) * radius));
        }
    }
    rings_mesh(vertices, TUBE_SIDES)
}

/// Rings of `sides` corners each, one after another, joined by triangles.
fn rings_mesh(corners: Vec<Point3<f64>>, sides: u32) -> Mesh {
    let vertices: Vec<Vector3<f32>> = corners.iter().map(|corner| corner.coords.cast()).collect();
    let rings = vertices.len() as u32 / sides;
    let mut triangles = Vec::new();
    for ring in 1..rings {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let [a, b] = [(ring - 1) * sides + side, (ring - 1) * sides + next];
            let [c, d] = [a + sides, b + sides];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let normals = vec![Vector3::z(); vertices.len()];
    Mesh { vertices, normals, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_have_their_volumes_right_side_out() {
        let place = Isometry3::translation(0.1, 0.2, -0.3);
        let ratio = |solid: Lathe, volume: f64| solid.mesh(&place).volume() / volume;
        assert!((ratio(Lathe::cylinder(0.03, 0.1), 2.827e-4) - 1.0).abs() < 0.03);
        assert!((ratio(Lathe::ball(0.03), 1.131e-4) - 1.0).abs() < 0.05);
        assert!((ratio(Lathe::cuboid([0.02, 0.04, 0.1]), 8e-5) - 1.0).abs() < 0.05);
    }

    #[test]
    fn a_tube_follows_its_path() {
        let path = [Vector3::zeros(), Vector3::new(0.0, 0.0, 0.1), Vector3::new(0.0, 0.1, 0.2)];
        let mesh = tube(&path, 0.01, &Isometry3::identity());
        for vertex in &mesh.vertices {
            let nearest = path.iter().map(|p| (p - vertex.cast()).norm()).fold(f64::INFINITY, f64::min);
            assert!((nearest - 0.01).abs() < 1e-6);
        }
    }
}
