//! A z-buffer rasteriser for small pictures: one pass over the vertices, one over the triangles.

use nalgebra::{Matrix3, Vector3};

/// Grey value below which no pixel of the hand falls: what is brighter than 0 is hand.
pub const HAND_FLOOR: u8 = 16;

/// Samples a pixel along each side.
const SUPER: usize = 2;

/// Border in samples that is kept free around the hand.
const MARGIN: f32 = 2.0;

/// How a picture is lit: one far light and an even one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    /// Toward the light, in the camera's frame (unit length).
    pub(crate) toward: Vector3<f32>,
    /// Share of the even light, 0 to 1.
    pub(crate) ambient: f32,
}

/// What is drawn: triangles of the hand, then black ones that hide it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawing {
    /// All vertices, relative to the point that the camera looks at.
    pub(crate) vertices: Vec<Vector3<f32>>,
    /// One unit normal a vertex.
    pub(crate) normals: Vec<Vector3<f32>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The first so many vertices and triangles are the hand's.
    pub(crate) hand_vertices: usize,
    pub(crate) hand_triangles: usize,
}

#[derive(Clone, Copy, Default)]
struct Projected {
    x: f32,
    y: f32,
    /// One over the depth: linear across a triangle in the picture.
    near: f32,
    grey: f32,
}

/// Draws into a square picture of `side` pixels, the hand filling the frame; 0 is outside the hand.
///
/// `turn` is the rotation into the camera's frame, `distance` the camera's distance from the point it
/// looks at, in the vertices' unit.
pub(crate) fn draw(
    drawing: &Drawing,
    turn: &Matrix3<f32>,
    distance: f32,
    light: &Light,
    side: usize,
) -> Vec<u8> {
    let samples = side * SUPER;
    let projected = project(drawing, turn, distance, light, samples as f32);
    let mut depth = vec![0f32; samples * samples];
    let mut grey = vec![0f32; samples * samples];
    for (i, t) in drawing.triangles.iter().enumerate() {
        let corners = t.map(|v| projected[v as usize]);
        fill(&corners, i < drawing.hand_triangles, samples, &mut depth, &mut grey);
    }
    shrink(&grey, side)
}

/// Projects and lights every vertex; the hand's box fills the frame.
fn project(
    drawing: &Drawing,
    turn: &Matrix3<f32>,
    distance: f32,
    light: &Light,
    samples: f32,
) -> Vec<Projected> {
    let to_light = turn.transpose() * light.toward;
    let floor = f32::from(HAND_FLOOR) + 8.0;
    let even = floor + (235.0 - floor) * light.ambient;
    let far = 235.0 - even;
    let mut out: Vec<Projected> = drawing
        .vertices
        .iter()
        .zip(&drawing.normals)
        .map(|(v, n)| {
            let c = turn * v;
            let near = 1.0 / (c.z + distance);
            Projected { x: c.x * near, y: c.y * near, near, grey: even + far * n.dot(&to_light).max(0.0) }
        })
        .collect();
    let hand = &out[..drawing.hand_vertices];
    let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
    for p in hand {
        low = [low[0].min(p.x), low[1].min(p.y)];
        high = [high[0].max(p.x), high[1].max(p.y)];
    }
    let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1e-9);
    let zoom = (samples - 2.0 * MARGIN) / extent;
    let shift = [0, 1].map(|i| 0.5 * (samples - zoom * (low[i] + high[i])));
    for p in &mut out {
        p.x = p.x * zoom + shift[0];
        p.y = p.y * zoom + shift[1];
    }
    out
}

/// Fills one triangle whose front faces the camera.
fn fill([a, b, c]: &[Projected; 3], is_hand: bool, samples: usize, depth: &mut [f32], grey: &mut [f32]) {
    // Outside counter-clockwise becomes clockwise when y points down: fronts have a negative area.
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if area >= 0.0 {
        return;
    }
    let last = samples as f32 - 1.0;
    let range = |u: f32, v: f32, w: f32| {
        let low = (u.min(v).min(w) - 0.5).ceil().max(0.0);
        let high = (u.max(v).max(w) - 0.5).floor().min(last);
        (low, high)
    };
    let (x0, x1) = range(a.x, b.x, c.x);
    let (y0, y1) = range(a.y, b.y, c.y);
    if x0 > x1 || y0 > y1 {
        return;
    }
    // Barycentric weights of `b` and `c` are planes over the picture.
    let scale = 1.0 / area;
    let (bx, by) = ((c.y - a.y) * scale, -(c.x - a.x) * scale);
    let (cx, cy) = (-(b.y - a.y) * scale, (b.x - a.x) * scale);
    let (dn_b, dn_c) = (b.near - a.near, c.near - a.near);
    let (dg_b, dg_c) = (b.grey - a.grey, c.grey - a.grey);
    let (columns, first) = ((x1 - x0) as usize + 1, x0 as usize);
    let mut y = y0;
    while y <= y1 {
        let (px, py) = (x0 + 0.5 - a.x, y + 0.5 - a.y);
        let (mut wb, mut wc) = (bx * px + by * py, cx * px + cy * py);
        let row = y as usize * samples + first;
        let cells = depth[row..row + columns].iter_mut().zip(&mut grey[row..row + columns]);
        for (d, g) in cells {
            if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
                let near = a.near + wb * dn_b + wc * dn_c;
                if near > *d {
                    *d = near;
                    *g = if is_hand { a.grey + wb * dg_b + wc * dg_c } else { 0.0 };
                }
            }
            wb += bx;
            wc += cx;
        }
        y += 1.0;
    }
}

/// Averages the samples of each pixel: a pixel is hand when at least half of its samples are.
fn shrink(grey: &[f32], side: usize) -> Vec<u8> {
    let samples = side * SUPER;
    let mut out = vec![0u8; side * side];
    for (i, pixel) in out.iter_mut().enumerate() {
        let (x, y) = (i % side * SUPER, i / side * SUPER);
        let (mut sum, mut count) = (0.0, 0);
        for row in 0..SUPER {
            let start = (y + row) * samples + x;
            for &g in &grey[start..start + SUPER] {
                sum += g;
                count += usize::from(g > 0.0);
            }
        }
        if 2 * count >= SUPER * SUPER {
            *pixel = (sum / count as f32).round().clamp(f32::from(HAND_FLOOR), 255.0) as u8;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, surface_nets};

    const FRONT: Light = Light { toward: Vector3::new(0.0, 0.0, -1.0), ambient: 0.3 };

    fn ball(radius: f64, centre: Vector3<f64>) -> Mesh {
        let half = Vector3::repeat(radius + 0.3);
        surface_nets(centre - half, centre + half, 0.1, |p| (p - centre).norm() - radius)
    }

    fn drawing(hand: Mesh, black: Mesh) -> Drawing {
        let offset = hand.vertices.len() as u32;
        let mut d = Drawing {
            hand_vertices: hand.vertices.len(),
            hand_triangles: hand.triangles.len(),
            vertices: hand.vertices,
            normals: hand.normals,
            triangles: hand.triangles,
        };
        d.vertices.extend(black.vertices);
        d.normals.extend(black.normals);
        d.triangles.extend(black.triangles.iter().map(|t| t.map(|v| v + offset)));
        d
    }

    #[test]
    fn a_ball_is_a_disc_without_holes_brightest_in_the_middle() {
        let d = drawing(ball(1.0, Vector3::zeros()), Mesh::default());
        let picture = draw(&d, &Matrix3::identity(), 50.0, &FRONT, 48);
        for y in 0..48 {
            for x in 0..48 {
                let out = (x as f32 - 23.5).hypot(y as f32 - 23.5) / 23.0;
                let g = picture[y * 48 + x];
                if out < 0.95 {
                    assert!(g > HAND_FLOOR, "hole at {x} {y}");
                } else if out > 1.05 {
                    assert_eq!(g, 0, "spill at {x} {y}");
                }
            }
        }
        assert!(picture[24 * 48 + 24] > picture[24 * 48 + 4] + 40);
    }

    #[test]
    fn black_things_hide_the_hand_only_when_they_are_in_front() {
        let hand = || ball(1.0, Vector3::zeros());
        let small = |z: f64| ball(0.5, Vector3::new(0.0, 0.0, z));
        let middle = |d: &Drawing| draw(d, &Matrix3::identity(), 10.0, &FRONT, 48)[24 * 48 + 24];
        assert_eq!(middle(&drawing(hand(), small(-2.0))), 0);
        assert!(middle(&drawing(hand(), small(2.0))) > HAND_FLOOR);
    }
}
