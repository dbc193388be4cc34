//! Normals that make facets look round.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::mesh::Mesh;

/// The cosine of the angle between two facets from which on their edge is sharp.
const CREASE: f32 = 0.75;
/// Corners that are nearer to each other are one, in metres.
const SAME: f32 = 1e-6;

/// The same surface, each triangle with corners of its own. A corner's normal is the mean of the
/// facets that meet in it and are turned less than a crease from its own, weighted by their areas.
///
/// By its facets a can would be told from a ball, and no real one has any.
pub(super) fn smoothed(mesh: &Mesh) -> Mesh {
    let corners_of = |triangle: &[u32; 3]| triangle.map(|v| mesh.vertices[v as usize]);
    let facet = |triangle: &[u32; 3]| {
        let [a, b, c] = corners_of(triangle);
        (b - a).cross(&(c - a))
    };
    let facets: Vec<Vector3<f32>> = mesh.triangles.iter().map(facet).collect();
    let mut meeting: HashMap<[i32; 3], Vec<Vector3<f32>>> = HashMap::new();
    for (triangle, facet) in mesh.triangles.iter().zip(&facets) {
        for corner in corners_of(triangle) {
            meeting.entry(key(&corner)).or_default().push(*facet);
        }
    }
    let mut out = Mesh::default();
    for (triangle, own) in mesh.triangles.iter().zip(&facets) {
        for corner in corners_of(triangle) {
            let near = meeting[&key(&corner)].iter().filter(|other| is_smooth(own, other));
            let normal = near.sum::<Vector3<f32>>();
            out.vertices.push(corner);
            out.normals.push(normal.try_normalize(0.0).unwrap_or_else(Vector3::z));
        }
        let first = 3 * out.triangles.len() as u32;
        out.triangles.push([first, first + 1, first + 2]);
    }
    out
}

/// The corner's place in steps in which rounding does not show.
fn key(corner: &Vector3<f32>) -> [i32; 3] {
    [corner.x, corner.y, corner.z].map(|v| (v / SAME).round_ties_even() as i32)
}

fn is_smooth(a: &Vector3<f32>, b: &Vector3<f32>) -> bool {
    a.dot(b) > CREASE * a.norm() * b.norm()
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::camera::things::solid::Lathe;

    fn of(solid: &Lathe) -> Mesh {
        smoothed(&solid.mesh(&Isometry3::identity()))
    }

    #[test]
    fn a_ball_is_round_and_its_facets_stay_in_their_places() {
        let (solid, mesh) = (Lathe::ball(0.03), of(&Lathe::ball(0.03)));
        assert!((mesh.volume() - solid.mesh(&Isometry3::identity()).volume()).abs() < 1e-9);
        // Facets are up to 15 degrees wide.
        for (vertex, normal) in mesh.vertices.iter().zip(&mesh.normals) {
            assert!(normal.z == 1.0 || normal.dot(&vertex.normalize()) > 0.995, "{vertex} {normal}");
        }
    }

    #[test]
    fn a_can_is_round_and_its_rims_are_sharp() {
        let mesh = of(&Lathe::cylinder(0.03, 0.1));
        for (vertex, normal) in mesh.vertices.iter().zip(&mesh.normals) {
            let out = Vector3::new(vertex.x, vertex.y, 0.0) / 0.03;
            let is_side = normal.dot(&out) > 0.999;
            assert!(is_side || normal.z.abs() > 0.999, "{vertex} {normal}");
        }
    }

    #[test]
    fn a_box_has_six_flat_sides() {
        let mesh = of(&Lathe::cuboid([0.02, 0.04, 0.1]));
        for normal in &mesh.normals {
            assert!(normal.amax() > 0.999, "{normal}");
        }
    }
}
