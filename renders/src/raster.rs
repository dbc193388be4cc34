//! A z-buffer rasteriser for small pictures: one pass over the vertices, one over the triangles.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

/// Grey value below which no pixel of the hand falls: what is brighter than 0 is hand.
pub const HAND_FLOOR: u8 = 16;

/// Samples a pixel along each side.
const SUPER: usize = 2;

/// Border in samples that is kept free around the hand.
const MARGIN: f32 = 2.0;

/// Rows of a triangle's box longer than this are narrowed before they are tested sample by sample.
const WIDE: usize = 10;

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

#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Projected {
    pub(crate) x: f32,
    pub(crate) y: f32,
    /// One over the depth: linear across a triangle in the picture.
    pub(crate) near: f32,
    pub(crate) grey: f32,
}

/// Draws into a square picture of `side` pixels, the hand filling the frame; 0 is outside the hand.
///
/// `turn` is the rotation into the camera's frame, `distance` the camera's distance from the point
/// it looks at, in the vertices' unit.
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
        let [a, b, c] = corners.map(|corner| corner.grey);
        if i < drawing.hand_triangles {
            let shade = |wb: f32, wc: f32, scale: f32| a + wb * ((b - a) * scale) + wc * ((c - a) * scale);
            fill(&corners, samples, &mut depth, &mut grey, shade);
        } else {
            fill(&corners, samples, &mut depth, &mut grey, |_, _, _| 0.0);
        }
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
            // What would lie behind the camera, an arm, is far out of the picture all the same.
            let near = 1.0 / (c.z + distance).max(0.1 * distance);
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
///
/// Where it is nearer than what was there, `out` becomes what `value` makes of the weights of the
/// corners `b` and `c`, which are still to be multiplied by its third argument.
pub(crate) fn fill<T>(
    [a, b, c]: &[Projected; 3],
    samples: usize,
    depth: &mut [f32],
    out: &mut [T],
    value: impl Fn(f32, f32, f32) -> T,
) {
    // Outside counter-clockwise becomes clockwise when y points down: fronts have a positive area
    // here.
    let area = (b.y - a.y) * (c.x - a.x) - (b.x - a.x) * (c.y - a.y);
    if area <= 0.0 {
        return;
    }
    // The samples between two coordinates, the upper one left out: samples lie at halves. Casting
    // cuts off the fraction and is much cheaper than rounding, and this runs for every triangle.
    let first = |v: f32| ((v.max(0.0) + 0.5) as i32 as usize).min(samples);
    let columns = first(a.x.min(b.x).min(c.x))..first(a.x.max(b.x).max(c.x));
    let rows = first(a.y.min(b.y).min(c.y))..first(a.y.max(b.y).max(c.y));
    if columns.is_empty() || rows.is_empty() {
        return;
    }
    // Barycentric weights of `b` and `c`, times the area, are planes over the picture.
    let (bx, by) = (a.y - c.y, c.x - a.x);
    let (cx, cy) = (b.y - a.y, a.x - b.x);
    let scale = 1.0 / area;
    let (near_b, near_c) = ((b.near - a.near) * scale, (c.near - a.near) * scale);
    let px = columns.start as f32 + 0.5 - a.x;
    for row in rows {
        let py = row as f32 + 0.5 - a.y;
        let (mut wb, mut wc) = (bx * px + by * py, cx * px + cy * py);
        let mut span = 0..columns.len();
        if span.len() > WIDE {
            span = narrow(span.len(), [(wb, bx), (wc, cx), (area - wb - wc, -bx - cx)]);
            wb += bx * span.start as f32;
            wc += cx * span.start as f32;
        }
        let start = row * samples + columns.start;
        let cells = start + span.start..start + span.end;
        for (d, o) in depth[cells.clone()].iter_mut().zip(&mut out[cells]) {
            if wb >= 0.0 && wc >= 0.0 && wb + wc <= area {
                let near = a.near + wb * near_b + wc * near_c;
                if near > *d {
                    *d = near;
                    *o = value(wb, wc, scale);
                }
            }
            wb += bx;
            wc += cx;
        }
    }
}

/// The part of a row of `len` samples in which no edge function `e0 + i * step` is negative, give
/// or take a sample: long slanting triangles are mostly air inside their box.
fn narrow(len: usize, edges: [(f32, f32); 3]) -> Range<usize> {
    let (mut low, mut high) = (0.0f32, len as f32);
    for (e0, step) in edges {
        if step > 0.0 {
            low = low.max(-e0 / step);
        } else if step < 0.0 {
            high = high.min(-e0 / step);
        }
    }
    let start = ((low - 1.0).max(0.0) as usize).min(len);
    let end = ((high + 2.0).max(0.0) as usize).min(len);
    start..end.max(start)
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
            *pixel = (sum / count as f32 + 0.5).clamp(f32::from(HAND_FLOOR), 255.0) as u8;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Balls, Mesh, surface_nets};
    use proptest::prelude::*;

    const FRONT: Light = Light { toward: Vector3::new(0.0, 0.0, -1.0), ambient: 0.3 };

    fn ball(radius: f64, centre: Vector3<f64>) -> Mesh {
        let half = Vector3::repeat(radius + 0.3);
        surface_nets(centre - half, centre + half, 0.1, &Balls(vec![(centre, radius)]))
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
                let out = libm::hypotf(x as f32 - 23.5, y as f32 - 23.5) / 23.0;
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

    fn corner() -> impl Strategy<Value = Projected> {
        (-20.0..60.0f32, -20.0..60.0f32, 0.1..2.0f32).prop_map(|(x, y, near)| Projected {
            x,
            y,
            near,
            grey: 100.0,
        })
    }

    proptest! {
        /// Each sample by itself, in double precision: inside all three edges or not.
        #[test]
        fn a_triangle_covers_the_samples_inside_it(corners in [corner(), corner(), corner()]) {
            const SIDE: usize = 40;
            let (mut depth, mut grey) = (vec![0f32; SIDE * SIDE], vec![0f32; SIDE * SIDE]);
            fill(&corners, SIDE, &mut depth, &mut grey, |_, _, _| 100.0);
            for (i, g) in grey.iter().enumerate() {
                let (x, y) = ((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5);
                // How far to the front's inside of each edge, in samples.
                let inside = (0..3)
                    .map(|k| {
                        let (p, q) = (corners[k], corners[(k + 1) % 3]);
                        let (dx, dy) = (f64::from(q.x - p.x), f64::from(q.y - p.y));
                        ((x - f64::from(p.x)) * dy - (y - f64::from(p.y)) * dx) / libm::hypot(dx, dy)
                    })
                    .fold(f64::INFINITY, f64::min);
                if inside > 1e-3 {
                    prop_assert!(*g > 0.0, "hole at {x} {y}");
                } else if inside < -1e-3 {
                    prop_assert_eq!(*g, 0.0, "spill at {} {}", x, y);
                }
            }
        }
    }
}
