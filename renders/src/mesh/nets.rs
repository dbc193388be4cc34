//! Naive surface nets (S. Gibson, "Constrained elastic surface nets", 1998): one vertex in every cell that
//! the surface passes through, one quad across every grid edge that it cuts.

use nalgebra::Vector3;

use super::Mesh;

/// Grid points along a block's side: blocks that the surface cannot reach are not sampled.
const BLOCK: usize = 8;

/// Meshes the zero level of `distance`, which must not change faster than the way moved, inside the box
/// from `low` to `high` with cells of side `cell`. The surface must not touch the box.
pub(crate) fn surface_nets(
    low: Vector3<f64>,
    high: Vector3<f64>,
    cell: f64,
    distance: impl Fn(&Vector3<f64>) -> f64,
) -> Mesh {
    let dims = ((high - low) / cell).map(|n| n.ceil().max(1.0) as usize + 1);
    let grid = sample(low, dims, cell, &distance);
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
                let (vertex, normal) = settle(start + local * cell, cell, &distance);
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

/// Distances at the grid points; far from the surface only their sign is right.
fn sample(
    low: Vector3<f64>,
    dims: Vector3<usize>,
    cell: f64,
    distance: &impl Fn(&Vector3<f64>) -> f64,
) -> Vec<f64> {
    let mut grid = vec![0.0; dims.x * dims.y * dims.z];
    let reach = cell * (BLOCK as f64 * 0.5 * 3f64.sqrt() + 1.0);
    for bz in (0..dims.z).step_by(BLOCK) {
        for by in (0..dims.y).step_by(BLOCK) {
            for bx in (0..dims.x).step_by(BLOCK) {
                let half = (BLOCK - 1) as f64 * 0.5;
                let middle = Vector3::new(bx as f64 + half, by as f64 + half, bz as f64 + half);
                let far = distance(&(low + middle * cell));
                for z in bz..(bz + BLOCK).min(dims.z) {
                    for y in by..(by + BLOCK).min(dims.y) {
                        for x in bx..(bx + BLOCK).min(dims.x) {
                            grid[(z * dims.y + y) * dims.x + x] = if far.abs() > reach {
                                far
                            } else {
                                let at = Vector3::new(x as f64, y as f64, z as f64);
                                distance(&(low + at * cell))
                            };
                        }
                    }
                }
            }
        }
    }
    grid
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

/// Moves a vertex onto the surface (one Newton step, at most half a cell) and gives the normal there.
fn settle(
    p: Vector3<f64>,
    cell: f64,
    distance: &impl Fn(&Vector3<f64>) -> f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let step = 0.25 * cell;
    let here = distance(&p);
    let gradient = Vector3::from_fn(|i, _| {
        let mut ahead = p;
        let mut behind = p;
        ahead[i] += step;
        behind[i] -= step;
        distance(&ahead) - distance(&behind)
    });
    let normal = gradient.try_normalize(1e-12).unwrap_or_else(Vector3::z);
    (p - normal * here.clamp(-0.5 * cell, 0.5 * cell), normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_round_and_right_side_out() {
        let low = Vector3::repeat(-1.3);
        let mesh = surface_nets(low, -low, 0.1, |p| p.norm() - 1.0);
        assert!(mesh.is_closed());
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((mesh.volume() - exact).abs() < 0.02 * exact, "{}", mesh.volume());
        for (v, n) in mesh.vertices.iter().zip(&mesh.normals) {
            assert!((v.norm() - 1.0).abs() < 1e-3);
            assert!(v.normalize().dot(n) > 0.999);
        }
    }

    #[test]
    fn two_bodies_apart_give_two_closed_shells() {
        let centre = Vector3::new(0.7, 0.0, 0.0);
        let mesh = surface_nets(Vector3::repeat(-1.5), Vector3::repeat(1.5), 0.1, |p| {
            ((p - centre).norm() - 0.5).min((p + centre).norm() - 0.5)
        });
        assert!(mesh.is_closed());
        let exact = 2.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.125;
        assert!((mesh.volume() - exact).abs() < 0.05 * exact);
    }
}
