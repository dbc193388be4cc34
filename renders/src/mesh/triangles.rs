//! Triangles.

use nalgebra::Vector3;

/// A triangle mesh in metres, outside counter-clockwise.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Corner places.
    pub(crate) vertices: Vec<Vector3<f32>>,
    /// Unit normals, one a corner, pointing out.
    pub(crate) normals: Vec<Vector3<f32>>,
    /// Corner numbers of each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds another mesh's triangles.
    pub(crate) fn append(&mut self, other: &Mesh) {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|c| c + offset)));
    }

    /// Whether every edge is passed as often in one direction as in the other: the mesh has no
    /// hole.
    #[cfg(test)]
    pub(crate) fn is_closed(&self) -> bool {
        let mut balance = std::collections::HashMap::new();
        // By place, not by number: a pole is many vertices in one place. Adding 0 makes -0 the same
        // as 0.
        let at = |i: u32| self.vertices[i as usize].map(|x| (x + 0.0).to_bits()).data.0[0];
        for t in &self.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (a, b) = (at(a), at(b));
                if a == b {
                    continue;
                }
                *balance.entry((a.min(b), a.max(b))).or_insert(0i32) += if a < b { 1 } else { -1 };
            }
        }
        balance.values().all(|&n| n == 0)
    }

    /// The enclosed volume in cubic metres; negative when inside out.
    #[cfg(test)]
    pub(crate) fn volume(&self) -> f64 {
        let at = |i: u32| self.vertices[i as usize].cast::<f64>();
        self.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0).sum()
    }
}
