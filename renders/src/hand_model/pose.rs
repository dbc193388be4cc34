//! The model's skin in any pose: linear blend skinning, and the cut through the wrist.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};

use super::HandModel;
use super::measure::{bend_axis, bone_axes};
use super::rig::{BONES, PALM, bone};
use crate::hand::{Digit, HandPose};
use crate::mesh::Mesh;

type V = Vector3<f64>;

impl HandModel {
    /// The skin in a pose, closed by a flat face at `cut_x` where it goes on behind.
    pub(crate) fn posed(&self, pose: &HandPose, cut_x: f64) -> Mesh {
        let moves = self.moves(pose);
        let vertices: Vec<Vector3<f32>> = self
            .skin
            .vertices
            .iter()
            .map(|vertex| {
                let place = |&(bone, weight): &(u8, f32)| {
                    let (turn, shift) = &moves[usize::from(bone)];
                    (turn * vertex.at + shift) * f64::from(weight)
                };
                vertex.bones.iter().filter(|(_, weight)| *weight > 0.0).map(place).sum::<V>().cast()
            })
            .collect();
        let normals = normals(&vertices, &self.skin.triangles);
        cut(Mesh { vertices, normals, triangles: self.skin.triangles.clone() }, cut_x as f32)
    }

    /// Rotation and shift that take each bone from where it is at rest to where it is in a pose.
    fn moves(&self, pose: &HandPose) -> [(Matrix3<f64>, V); BONES] {
        let mut moves = [(Matrix3::identity(), V::zeros()); BONES];
        let skeleton = self.skeleton();
        for digit in Digit::ALL {
            let chain = skeleton.chain(digit, &pose.digits[digit as usize]);
            let axis = bend_axis(&chain);
            for (i, (rest, rest_axes)) in self.rest.bones[digit as usize].iter().enumerate() {
                let along = (chain.points[i + 1] - chain.points[i]).normalize();
                let turn = bone_axes(&along, &axis) * rest_axes.transpose();
                moves[bone(digit, i)] = (turn, chain.points[i] - turn * rest);
            }
        }
        debug_assert_eq!(moves[PALM].1, V::zeros());
        moves
    }
}

/// Normals of a smooth surface: the mean of the triangles around a vertex, by their areas.
fn normals(vertices: &[Vector3<f32>], triangles: &[[u32; 3]]) -> Vec<Vector3<f32>> {
    let mut normals = vec![Vector3::zeros(); vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| vertices[i as usize]);
        let normal = (b - a).cross(&(c - a));
        for &i in triangle {
            normals[i as usize] += normal;
        }
    }
    // Square metres of small triangles are small numbers.
    normals.into_iter().map(|n| n.try_normalize(1e-20).unwrap_or_else(Vector3::z)).collect()
}

/// What lies at `x` or before it, with a flat face where the surface was cut.
fn cut(mesh: Mesh, x: f32) -> Mesh {
    let mut kept =
        Cut { from: &mesh, x, out: Mesh::default(), vertices: HashMap::new(), edges: HashMap::new() };
    let mut rim = Vec::new();
    for triangle in &mesh.triangles {
        rim.extend(kept.add(triangle));
    }
    let mut out = kept.out;
    if !rim.is_empty() {
        let sum: Vector3<f32> =
            rim.iter().flatten().map(|&i| out.vertices[i as usize]).fold(Vector3::zeros(), |sum, v| sum + v);
        let middle = out.vertices.len() as u32;
        out.vertices.push(Vector3::new(x, sum.y / (2 * rim.len()) as f32, sum.z / (2 * rim.len()) as f32));
        out.normals.push(-Vector3::x());
        out.triangles.extend(rim.iter().map(|&[a, b]| [middle, b, a]));
    }
    out
}

struct Cut<'a> {
    from: &'a Mesh,
    x: f32,
    out: Mesh,
    /// New numbers of the vertices that are kept, and of those that edges get where they are cut.
    vertices: HashMap<u32, u32>,
    edges: HashMap<(u32, u32), u32>,
}

impl Cut<'_> {
    /// Adds what is left of a triangle; gives the edge along the cut, if there is one.
    fn add(&mut self, triangle: &[u32; 3]) -> Option<[u32; 2]> {
        let inside = triangle.map(|i| self.from.vertices[i as usize].x >= self.x);
        if inside == [true; 3] {
            let kept = triangle.map(|i| self.vertex(i));
            self.out.triangles.push(kept);
            return None;
        }
        // Turned so that the vertex that is alone on its side comes first.
        let turned = |first: usize| [0, 1, 2].map(|i| triangle[(first + i) % 3]);
        let alone = |side: bool| (0..3).find(|&i| inside[i] == side);
        match inside.iter().filter(|side| **side).count() {
            1 => {
                let [a, b, c] = turned(alone(true)?);
                let (ab, ac) = (self.edge(a, b), self.edge(a, c));
                let a = self.vertex(a);
                self.out.triangles.push([a, ab, ac]);
                Some([ab, ac])
            }
            2 => {
                let [a, b, c] = turned(alone(false)?);
                let (ab, ac) = (self.edge(a, b), self.edge(a, c));
                let (b, c) = (self.vertex(b), self.vertex(c));
                self.out.triangles.push([ab, b, c]);
                self.out.triangles.push([ab, c, ac]);
                Some([ac, ab])
            }
            _ => None,
        }
    }

    fn vertex(&mut self, i: u32) -> u32 {
        *self.vertices.entry(i).or_insert_with(|| {
            self.out.vertices.push(self.from.vertices[i as usize]);
            self.out.normals.push(self.from.normals[i as usize]);
            self.out.vertices.len() as u32 - 1
        })
    }

    /// The vertex where an edge is cut, the same from both sides.
    fn edge(&mut self, a: u32, b: u32) -> u32 {
        let key = (a.min(b), a.max(b));
        *self.edges.entry(key).or_insert_with(|| {
            let [p, q] = [key.0, key.1].map(|i| self.from.vertices[i as usize]);
            let [m, n] = [key.0, key.1].map(|i| self.from.normals[i as usize]);
            let t = (self.x - p.x) / (q.x - p.x);
            let mut at = p + (q - p) * t;
            at.x = self.x;
            self.out.vertices.push(at);
            self.out.normals.push((m + (n - m) * t).try_normalize(1e-9).unwrap_or(m));
            self.out.vertices.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Balls, surface_nets};

    #[test]
    fn a_cut_ball_is_closed_and_half_as_large() {
        let low = Vector3::repeat(-1.3);
        let ball = surface_nets(low, -low, 0.1, &Balls(vec![(Vector3::zeros(), 1.0)]));
        let whole = ball.volume();
        let half = cut(ball.clone(), 0.0131);
        assert!(half.is_closed());
        assert!((half.volume() / whole - 0.49).abs() < 0.01, "{}", half.volume() / whole);
        assert!(half.vertices.iter().all(|v| v.x >= 0.0131));
        assert_eq!(cut(ball.clone(), -2.0).triangles.len(), ball.triangles.len());
        assert!(cut(ball, 2.0).triangles.is_empty());
    }
}
