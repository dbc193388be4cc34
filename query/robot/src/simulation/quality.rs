//! How good a grasp is: how hard it can be shaken, and how well its contacts resist any
//! disturbance.

use nalgebra::{Vector3, Vector6};
use rapier3d::math::Vector;
use serde::Serialize;

use super::trial::{Offset, Plan};
use super::world::{DT, Touch};

/// How fast the acceleration grows, in m/s^3, and up to what, in m/s^2.
const RAMP: f32 = 500.0;
const HARDEST: f32 = 1000.0;
/// A shaken object that has moved as far in the hand has slipped, in metres.
const SLIPPED: f32 = 0.005;
/// Directions from which the search for the least resisted wrench starts, and its steps from each.
const STARTS: u32 = 256;
const ROUNDS: u32 = 250;
/// Edges of the pyramid that stands for a contact's friction cone.
const EDGES: u32 = 8;

/// How good a grasp is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// The least acceleration, of six directions, that moves the object by 5 mm in the hand, in
    /// m/s^2, gravity not counted; null where none up to 1000 m/s^2 does.
    pub shake_m_s2: Option<f64>,
    /// Ferrari and Canny's epsilon, for contact forces that sum to 1 and torques in units of the
    /// object's radius: the least wrench that the contacts cannot resist. It is found by a search
    /// among directions and so is an upper bound, of the epsilon of friction cones with eight
    /// edges. 0: some wrench is not resisted at all.
    pub epsilon: f64,
}

impl Plan {
    /// How good the grasp is, the world being off by `offset`; `None` where the object was not
    /// lifted.
    pub fn quality(&self, offset: Offset) -> Option<Quality> {
        let (outcome, world) = self.run_watched(offset, |_, _| {});
        if !outcome.success {
            return None;
        }
        let radius = self.object().shape.reach(&Vector3::new(1.0, 1.0, 1.0).normalize()) as f32;
        let epsilon = epsilon(&world.touches(), self.object().friction as f32, radius);
        let axes = [Vector::X, Vector::Y, Vector::Z];
        let shaken =
            axes.into_iter().flat_map(|axis| [axis, -axis]).filter_map(|axis| self.shake(offset, axis));
        Some(Quality { shake_m_s2: shaken.reduce(f64::min), epsilon })
    }

    /// The acceleration at which the held object slips in a direction.
    fn shake(&self, offset: Offset, direction: Vector) -> Option<f64> {
        let (_, mut world) = self.run_watched(offset, |_, _| {});
        let held = world.palm_from_object().translation;
        for step in 1..=(HARDEST / RAMP / DT) as u32 {
            let acceleration = RAMP * DT * step as f32;
            world.pull_object(direction * acceleration);
            world.step();
            if (world.palm_from_object().translation - held).length() > SLIPPED {
                return Some(f64::from(acceleration));
            }
        }
        None
    }
}

/// Epsilon of contacts on an object about its middle; `radius` makes lengths of torques.
fn epsilon(touches: &[Touch], friction: f32, radius: f32) -> f64 {
    let mut wrenches = Vec::new();
    for touch in touches {
        let side = touch.normal.any_orthonormal_vector();
        let other = touch.normal.cross(side);
        for edge in 0..EDGES {
            let (sin, cos) = (std::f32::consts::TAU * edge as f32 / EDGES as f32).sin_cos();
            let force = touch.normal + friction * (cos * side + sin * other);
            let torque = touch.point.cross(force) / radius;
            let parts = [force.x, force.y, force.z, torque.x, torque.y, torque.z].map(f64::from);
            wrenches.push(Vector6::from(parts));
        }
    }
    inner_radius(&wrenches)
}

/// The radius of the largest ball about 0 in the convex hull of points in six dimensions, or a
/// little more; 0 where 0 is outside.
///
/// It is the least, over directions, of the hull's reach; from many directions the search goes
/// downhill.
fn inner_radius(points: &[Vector6<f64>]) -> f64 {
    let reach = |direction: &Vector6<f64>| {
        points.iter().map(|point| (point.dot(direction), point)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut least = f64::INFINITY;
    for start in starts() {
        let mut direction = start;
        for round in 0..ROUNDS {
            let Some((distance, farthest)) = reach(&direction) else { return 0.0 };
            least = least.min(distance);
            let step = 0.5 / f64::from(round + 2);
            direction = (direction - farthest * step).try_normalize(1e-12).unwrap_or(start);
        }
    }
    least.max(0.0)
}

/// Directions spread evenly, always the same ones: the points of a low-discrepancy sequence (M.
/// Roberts' R6) in a cube about 0.
fn starts() -> impl Iterator<Item = Vector6<f64>> {
    // The root of x^7 = x + 1.
    const RATIO: f64 = 1.112_775_684_278_705_5;
    (1..=STARTS).filter_map(|n| {
        let axis = |axis: i32| 2.0 * (0.5 + f64::from(n) * RATIO.powi(-axis)).fract() - 1.0;
        Vector6::from([1, 2, 3, 4, 5, 6].map(axis)).try_normalize(1e-9)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_in_a_cross_polytope_is_found() {
        let axes = (0..6).flat_map(|axis| [1.0, -1.0].map(|sign| sign * Vector6::ith(axis, 1.0)));
        let points: Vec<Vector6<f64>> = axes.collect();
        let radius = inner_radius(&points);
        assert!((radius - 1.0 / 6.0_f64.sqrt()).abs() < 0.01, "{radius}");
    }

    #[test]
    fn one_contact_resists_nothing_and_six_faces_hold_a_cube() {
        let touch = |normal: Vector| Touch { point: -normal, normal, force: 1.0, part: 1 };
        assert_eq!(epsilon(&[touch(Vector::X)], 0.8, 1.0), 0.0);
        assert_eq!(epsilon(&[], 0.8, 1.0), 0.0);
        let six: Vec<Touch> = [Vector::X, Vector::Y, Vector::Z]
            .into_iter()
            .flat_map(|axis| [touch(axis), touch(-axis)])
            .collect();
        // Hardest to resist is a torque about a diagonal: two of its three parts are within a
        // contact's reach.
        for friction in [0.2_f32, 0.8] {
            let expected = f64::from(friction) * (2.0_f64 / 3.0).sqrt();
            let found = epsilon(&six, friction, 1.0);
            assert!(expected <= found + 1e-6 && found < expected + 0.02, "{found} {expected}");
        }
    }
}
