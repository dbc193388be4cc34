//! Naive surface nets (S. Gibson, "Constrained elastic surface nets", 1998): one vertex in every
//! cell that the surface passes through, one quad across every grid edge that it cuts.

use nalgebra::Vector3;

use super::triangles::Mesh;

/// Grid points along the side of the blocks that are looked at first, a power of 2.
const BLOCK: usize = 16;
/// Cells that the surface passes through have their corners within a cell's diagonal of it.
const DIAGONAL: f64 = 1.75;

/// A signed distance in metres, negative inside, that changes no faster than the way moved.
pub(crate) trait Field {
    /// The distance at a point.
    fn distance(&self, p: &Vector3<f64>) -> f64;

    /// The same field for points within `radius` metres of `centre`: what cannot matter there may
    /// be left out.
    fn near(&self, centre: &Vector3<f64>, radius: f64) -> Self;
}

/// Meshes the zero level of a field inside the box from `low` to `high` with cells of side `cell`.
/// The surface must not touch the box.
pub(crate) fn surface_nets<F: Field>(low: Vector3<f64>, high: Vector3<f64>, cell: f64, field: &F) -> Mesh {
    let dims = ((high - low) / cell).map(|n| n.ceil().max(1.0) as usize + 1);
    let mut samples = Samples { low, cell, dims, grid: vec![0.0; dims.x * dims.y * dims.z] };
    for z in (0..dims.z).step_by(BLOCK) {
        for y in (0..dims.y).step_by(BLOCK) {
            for x in (0..dims.x).step_by(BLOCK) {
                samples.fill(field, Vector3::new(x, y, z), BLOCK);
            }
        }
    }
    let grid = samples.grid;
    let index = |x: usize, y: usize, z: usize| (z * dims.y + y) * dims.x + x;

    let mut mesh = Mesh::default();
    let mut cell_vertex = vec![u32::MAX; grid.len()];
    for z in 0..dims.z - 1 {
        for y in 0..dims.y - 1 {
            for x in 0..dims.x - 1 {
                let corners: [f64; 8] =
                    std::array::from_fn(|c| grid[index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))]);
                let inside = corners.iter().filter(|d| **d < 0.0).count();
                if inside == 0 || inside == 8 {
                    continue;
                }
                let local = mean_crossing(&corners);
                let start = low + Vector3::new(x as f64, y as f64, z as f64) * cell;
                let (here, normal) = interpolate(&corners, &local);
                let vertex = start + local * cell - normal * here.clamp(-0.5 * cell, 0.5 * cell);
                cell_vertex[index(x, y, z)] = mesh.vertices.len() as u32;
                mesh.vertices.push(vertex.cast());
                mesh.normals.push(normal.cast());
            }
        }
    }

    let strides = [1, dims.x, dims.x * dims.y];
    for z in 1..dims.z - 1 {
        for y in 1..dims.y - 1 {
            for x in 1..dims.x - 1 {
                let here = index(x, y, z);
                for axis in 0..3 {
                    let inside = grid[here] < 0.0;
                    if inside == (grid[here + strides[axis]] < 0.0) {
                        continue;
                    }
                    let (u, v) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
                    let quad = [here - u - v, here - v, here, here - u].map(|i| cell_vertex[i]);
                    let [a, b, c, d] = if inside { quad } else { [quad[0], quad[3], quad[2], quad[1]] };
                    mesh.triangles.push([a, b, c]);
                    mesh.triangles.push([a, c, d]);
                }
            }
        }
    }
    mesh
}

/// A field at the grid's points. Far from the surface only the sign is right.
struct Samples {
    low: Vector3<f64>,
    cell: f64,
    dims: Vector3<usize>,
    grid: Vec<f64>,
}

impl Samples {
    /// Samples a block of `side` points a side, in eighths as long as the surface may pass through
    /// them.
    fn fill<F: Field>(&mut self, field: &F, first: Vector3<usize>, side: usize) {
        let half = (side - 1) as f64 * 0.5;
        let middle = self.low + first.map(|i| i as f64 + half) * self.cell;
        let radius = self.cell * half * 3f64.sqrt();
        let far = field.distance(&middle);
        if far.abs() > radius + DIAGONAL * self.cell {
            self.each(first, side, |_| far);
        } else if side == 2 {
            self.each(first, side, |p| field.distance(p));
        } else {
            let near = field.near(&middle, radius);
            let side = side / 2;
            for eighth in 0..8 {
                let shift = Vector3::from_fn(|axis, _| (eighth >> axis & 1) * side);
                let first = first + shift;
                if first.zip_fold(&self.dims, true, |inside, first, dim| inside && first < dim) {
                    self.fill(&near, first, side);
                }
            }
        }
    }

    /// Sets every point of a block that lies in the grid.
    fn each(&mut self, first: Vector3<usize>, side: usize, value: impl Fn(&Vector3<f64>) -> f64) {
        let end = first.zip_map(&self.dims, |first, dim| (first + side).min(dim));
        for z in first.z..end.z {
            for y in first.y..end.y {
                for x in first.x..end.x {
                    let at = self.low + Vector3::new(x as f64, y as f64, z as f64) * self.cell;
                    self.grid[(z * self.dims.y + y) * self.dims.x + x] = value(&at);
                }
            }
        }
    }
}

/// The mean of the places where the surface cuts the cell's edges, in cell units.
fn mean_crossing(corners: &[f64; 8]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    let mut count = 0.0;
    for from in 0..8usize {
        for axis in 0..3 {
            let to = from | 1 << axis;
            let (a, b) = (corners[from], corners[to]);
            if to == from || (a < 0.0) == (b < 0.0) {
                continue;
            }
            let mut at = Vector3::from_fn(|i, _| (from >> i & 1) as f64);
            at[axis] = a / (a - b);
            sum += at;
            count += 1.0;
        }
    }
    sum / count
}

/// The field inside a cell, from its corners: its value and the direction in which it grows.
fn interpolate(corners: &[f64; 8], local: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let mut value = 0.0;
    let mut gradient = Vector3::zeros();
    for (corner, distance) in corners.iter().enumerate() {
        let upper = |axis: usize| corner >> axis & 1 == 1;
        let share = Vector3::from_fn(|i, _| if upper(i) { local[i] } else { 1.0 - local[i] });
        value += distance * share.product();
        for axis in 0..3 {
            let others = share[(axis + 1) % 3] * share[(axis + 2) % 3];
            gradient[axis] += if upper(axis) { distance * others } else { -distance * others };
        }
    }
    (value, gradient.try_normalize(1e-12).unwrap_or_else(Vector3::z))
}

#[cfg(test)]
mod tests {
    use super::super::Balls;
    use super::*;

    #[test]
    fn a_sphere_is_closed_round_and_right_side_out() {
        let low = Vector3::repeat(-1.3);
        let mesh = surface_nets(low, -low, 0.1, &Balls(vec![(Vector3::zeros(), 1.0)]));
        assert!(mesh.is_closed());
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((mesh.volume() - exact).abs() < 0.02 * exact, "{}", mesh.volume());
        for (v, n) in mesh.vertices.iter().zip(&mesh.normals) {
            assert!((v.norm() - 1.0).abs() < 4e-3);
            assert!(v.normalize().dot(n) > 0.998);
        }
    }

    #[test]
    fn two_bodies_apart_give_two_closed_shells() {
        let centre = Vector3::new(0.7, 0.0, 0.0);
        let balls = Balls(vec![(centre, 0.5), (-centre, 0.5)]);
        let mesh = surface_nets(Vector3::repeat(-1.5), Vector3::repeat(1.5), 0.1, &balls);
        assert!(mesh.is_closed());
        let exact = 2.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.125;
        assert!((mesh.volume() - exact).abs() < 0.05 * exact);
    }
}
