//! Triangles, with all that a picture asks of them.

use nalgebra::{Isometry3, Vector3};

use super::marks::Mark;
use super::wrist::Wrist;
use crate::mesh::Mesh;

/// Meshes of numbered parts.
#[derive(Debug, Clone, Default)]
pub(super) struct SurfaceMesh {
    pub(super) vertices: Vec<Vector3<f32>>,
    /// The same on the part itself: while the wrist was straight, before it was moved.
    pub(super) places: Vec<Vector3<f32>>,
    /// One unit normal a vertex.
    pub(super) normals: Vec<Vector3<f32>>,
    /// What the skin has at each vertex.
    pub(super) marks: Vec<Mark>,
    /// Corners, and the part that they are of.
    pub(super) triangles: Vec<([u32; 3], u8)>,
}

impl SurfaceMesh {
    /// Adds a part that is not skin.
    pub(super) fn add(&mut self, mesh: &Mesh, part: u8) {
        self.add_hand(mesh, &[], part);
    }

    /// Adds a hand, `marks` at each of its vertices.
    pub(super) fn add_hand(&mut self, mesh: &Mesh, marks: &[Mark], part: u8) {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&mesh.vertices);
        self.places.extend(&mesh.vertices);
        self.normals.extend(&mesh.normals);
        self.marks.extend(marks);
        self.marks.resize(self.vertices.len(), Mark::default());
        self.triangles.extend(mesh.triangles.iter().map(|corners| (corners.map(|c| c + offset), part)));
    }

    /// Adds all of another.
    pub(super) fn append(&mut self, other: &Self) {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.places.extend(&other.places);
        self.normals.extend(&other.normals);
        self.marks.extend(&other.marks);
        let moved = |&(corners, part): &([u32; 3], u8)| (corners.map(|c| c + offset), part);
        self.triangles.extend(other.triangles.iter().map(moved));
    }

    /// What was added from vertex `first` on.
    pub(super) fn from(&self, first: usize) -> Self {
        let is_in = |corners: &[u32; 3]| corners.iter().all(|&c| c as usize >= first);
        let triangles = self.triangles.iter().filter(|(corners, _)| is_in(corners));
        Self {
            vertices: self.vertices[first..].to_vec(),
            places: self.places[first..].to_vec(),
            normals: self.normals[first..].to_vec(),
            marks: self.marks[first..].to_vec(),
            triangles: triangles.map(|&(corners, part)| (corners.map(|c| c - first as u32), part)).collect(),
        }
    }

    /// Bends what there is, hand and arm.
    pub(super) fn bend(&mut self, wrist: &Wrist) {
        for (vertex, normal) in self.vertices.iter_mut().zip(&mut self.normals) {
            wrist.bend(vertex, normal);
        }
    }

    /// Makes a left hand of a right one.
    pub(super) fn mirror(&mut self) {
        for v in self.vertices.iter_mut().chain(&mut self.normals) {
            v.y = -v.y;
        }
        // Outside stays outside.
        self.triangles.iter_mut().for_each(|([_, b, c], _)| std::mem::swap(b, c));
    }

    pub(super) fn place(&mut self, place: &Isometry3<f32>) {
        self.vertices.iter_mut().for_each(|v| *v = place.rotation * *v + place.translation.vector);
        self.normals.iter_mut().for_each(|n| *n = place.rotation * *n);
    }

    /// Points all over it, no farther from each other than about `step` metres; of the corners of
    /// triangles that are smaller one.
    pub(super) fn points(&self, step: f32) -> impl Iterator<Item = Vector3<f32>> + '_ {
        self.triangles.iter().flat_map(move |(corners, _)| {
            // From a corner along the longest edge, and from there towards the third corner.
            let [mut a, mut b, mut c] = corners.map(|v| self.vertices[v as usize]);
            for _ in 0..2 {
                if (b - a).norm_squared() < (c - b).norm_squared().max((a - c).norm_squared()) {
                    (a, b, c) = (b, c, a);
                }
            }
            let (along, across) = (b - a, c - a);
            let length = along.norm();
            let steps = |far: f32| (far / step) as u16;
            let columns = steps(length);
            let rows = steps(along.cross(&across).norm() / length.max(1e-9));
            let share = |i: u16, of: u16| f32::from(i) / f32::from(of.max(1));
            (0..=rows).flat_map(move |j| {
                let left = 1.0 - share(j, rows);
                (0..=columns).map(move |i| a + across * (1.0 - left) + along * (share(i, columns) * left))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::things::solid::Lathe;

    fn box_of(part: u8) -> SurfaceMesh {
        let mut out = SurfaceMesh::default();
        out.add(&Lathe::cuboid([0.02, 0.04, 0.1]).mesh(&nalgebra::Isometry3::identity()), part);
        out
    }

    fn volume(mesh: &SurfaceMesh) -> f32 {
        let of = |(corners, _): &([u32; 3], u8)| {
            let [a, b, c] = corners.map(|v| mesh.vertices[v as usize]);
            a.dot(&b.cross(&c)) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    #[test]
    fn a_mirrored_body_is_right_side_out() {
        let (body, mut mirrored) = (box_of(1), box_of(1));
        mirrored.mirror();
        assert!((volume(&mirrored) - volume(&body)).abs() < 1e-7 && volume(&body) > 7e-5);
    }

    #[test]
    fn what_was_added_last_comes_out_again() {
        let (mut both, second) = (box_of(1), box_of(2));
        let first = both.vertices.len();
        both.append(&second);
        let out = both.from(first);
        assert_eq!((out.vertices, out.triangles), (second.vertices, second.triangles));
    }

    #[test]
    fn points_are_everywhere_on_a_body() {
        let points: Vec<_> = box_of(1).points(0.01).collect();
        let on_its_side = Vector3::new(0.01, 0.0, 0.013);
        let nearest = points.iter().map(|p| (p - on_its_side).norm()).fold(f32::MAX, f32::min);
        assert!(nearest < 0.01, "{nearest}");
    }
}
