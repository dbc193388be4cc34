//! The outline of a convex shape that is seen from afar.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Vector3};

use super::Shape;
use super::pose::rounded;

/// Corners that stand for a circle.
const SIDES: u32 = 32;
/// Three points whose triangle's doubled area is less, in square metres, lie on a line.
const FLAT: f64 = 1e-9;

/// The outline of `shape` as it is seen against `right` x `up`, in metres along both: convex,
/// counter-clockwise, to a micrometre.
pub(super) fn outline(
    shape: Shape,
    world_from_shape: &Isometry3<f64>,
    right: &Vector3<f64>,
    up: &Vector3<f64>,
) -> Vec<[f64; 2]> {
    let toward = right.cross(up);
    let middle = world_from_shape.translation.vector;
    let points = match shape {
        Shape::Box { size } => {
            let [x, y, z] = size.map(|length| 0.5 * length);
            let signs = [-1.0, 1.0];
            signs
                .into_iter()
                .flat_map(|a| {
                    signs.into_iter().flat_map(move |b| signs.map(|c| Vector3::new(a * x, b * y, c * z)))
                })
                .map(|corner| middle + world_from_shape * corner)
                .collect()
        }
        Shape::Cylinder { radius, height } => {
            let axis = world_from_shape * Vector3::z();
            // The ring's outermost points lie to both sides of the axis: with them a lying cylinder
            // is as wide as it is.
            let side = toward.cross(&axis).try_normalize(1e-9).unwrap_or(*right);
            let ring = ring(side, axis.cross(&side), radius);
            ring.flat_map(|point| [-0.5, 0.5].map(|end| middle + point + axis * (end * height))).collect()
        }
        Shape::Sphere { radius } => ring(*right, *up, radius).map(|point| middle + point).collect::<Vec<_>>(),
    };
    let flat = points.iter().map(|point| [point.dot(right), point.dot(up)]).collect();
    straightened(hull(flat)).into_iter().map(|point| point.map(rounded)).collect()
}

fn ring(right: Vector3<f64>, up: Vector3<f64>, radius: f64) -> impl Iterator<Item = Vector3<f64>> {
    (0..SIDES).map(move |side| {
        let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
        (right * cos + up * sin) * radius
    })
}

/// The convex hull, counter-clockwise, by Andrew's monotone chain.
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut hull = chain(points.iter().copied());
    hull.extend(chain(points.iter().rev().copied()));
    hull
}

/// The chain below the points, which come from left to right, without its last one, which begins
/// the chain back.
fn chain(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..]
            && turn(a, b, point) <= 0.0
        {
            chain.pop();
        }
        chain.push(point);
    }
    chain.pop();
    chain
}

/// Without the corners of a convex outline that rounding has made: of those that all but coincide
/// one stays. While the hull is sought nothing may be left out so, as a point beside an edge need
/// not lie between its ends.
fn straightened(mut outline: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut at = 0;
    while let Some(&corner) = outline.get(at).filter(|_| outline.len() > 3) {
        let before = at.checked_sub(1).and_then(|before| outline.get(before)).or(outline.last());
        let after = outline.get(at + 1).or(outline.first());
        match before.zip(after) {
            Some((before, after)) if turn(*before, corner, *after) < FLAT => {
                outline.remove(at);
            }
            _ => at += 1,
        }
    }
    outline
}

/// The doubled area of a triangle, positive where it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    fn above(shape: Shape, turned: UnitQuaternion<f64>) -> Vec<[f64; 2]> {
        let pose = Isometry3::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), turned);
        outline(shape, &pose, &Vector3::x(), &Vector3::y())
    }

    fn turned(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::new(axis * degrees.to_radians())
    }

    #[test]
    fn a_turned_box_is_a_turned_rectangle() {
        let shape = Shape::Box { size: [0.2, 0.1, 0.3] };
        assert_eq!(
            above(shape, UnitQuaternion::identity()),
            [[0.9, 1.95], [1.1, 1.95], [1.1, 2.05], [0.9, 2.05]]
        );
        let corners = above(shape, turned(Vector3::z(), 90.0));
        assert_eq!(corners, [[0.95, 1.9], [1.05, 1.9], [1.05, 2.1], [0.95, 2.1]]);
        assert_eq!(above(shape, turned(Vector3::new(1.0, 1.0, 1.0).normalize(), 40.0)).len(), 6);
    }

    #[test]
    fn a_cylinder_is_a_circle_from_its_end_and_a_rectangle_from_its_side() {
        let shape = Shape::Cylinder { radius: 0.05, height: 0.3 };
        let upright = above(shape, UnitQuaternion::identity());
        assert_eq!(upright.len(), SIDES as usize);
        assert!(upright.iter().all(|[x, y]| ((x - 1.0).hypot(y - 2.0) - 0.05).abs() < 2e-6));
        // All but exactly level, as after the rounding of a file.
        let lying = above(shape, turned(Vector3::y(), 90.000_001));
        assert_eq!(lying, [[0.85, 1.95], [1.15, 1.95], [1.15, 2.05], [0.85, 2.05]]);
        // Leaning: two half ellipses and what is between them.
        let leaning = above(shape, turned(Vector3::y(), 30.0));
        let reach = |axis: usize| leaning.iter().map(|point| point[axis]).fold(f64::MIN, f64::max);
        let expected = 0.15 * 0.5 + 0.05 * 30f64.to_radians().cos();
        assert!((reach(0) - 1.0 - expected).abs() < 1e-5 && (reach(1) - 2.05).abs() < 1e-5, "{leaning:?}");
    }
}
