//! Fitting an object into a hand whose pose is known.
//!
//! The object starts where the grasp puts it, and a least-squares fit moves, tilts and scales it
//! until it lies against the digits that must touch it and in none of the others. The touching
//! digits then close the gap that is left.

use nalgebra::{SVector, Unit, UnitQuaternion, Vector3};

use super::definition::{Grasp, Placement};
use super::grip::{Grip, against_palm, between_tips_of, fit, gap, palm_sheet};
use super::least_squares::{Damping, LeastSquares};
use super::object::{Object, PlacedObject};
use crate::hand::{Chain, Digit, HandPose, Skeleton};

type V = Vector3<f64>;

/// Place (3), tilt about two axes (2) and the logarithm of the size (1).
const UNKNOWNS: usize = 6;
/// What a unit of each residual is: metres of a gap at an end bone, at a middle bone, and inside
/// the flesh; of the object's place, its tilt in radians, and its size as the logarithm of the
/// ratio.
const END_GAP: f64 = 0.002;
const MIDDLE_GAP: f64 = 0.008;
const INSIDE: f64 = 0.001;
const PLACE: f64 = 0.020;
const TILT: f64 = 0.35;
const SIZE: f64 = 0.25;
const FIT: LeastSquares =
    LeastSquares { damping: Damping::Scaled, start: 1.0, rejected: 8.0, difference: 1e-5, steps: 25 };
/// A flat hand would take a ball of any size: the logarithm of the size changes by so much at most.
const MOST_SCALED: f64 = 0.4;
/// Residuals: end bone, middle bone and three depths a digit, the depth of the palm, the unknowns
/// themselves.
const ROWS: usize = 5 * 5 + 1 + UNKNOWNS;

/// Puts an object of about this size into a hand in about this pose.
pub(crate) fn hold(skeleton: &Skeleton, grasp: &Grasp, object: Object, pose: &HandPose) -> Grip {
    let chains = skeleton.chains(pose);
    let (start, away) = match &grasp.object.placement {
        Placement::Palm { anchor, push } => (against_palm(skeleton, grasp, object, *anchor, push), *push),
        Placement::Tips { between } => between_tips_of(skeleton, grasp, object, between, &chains),
    };
    let placed = settle(skeleton, grasp, start, &chains);
    let mut pose = *pose;
    for digit in Digit::ALL {
        if grasp.touch.contains(&digit) {
            let joints = &mut pose.digits[digit as usize];
            *joints = fit(skeleton, digit, *joints, &placed, &|p: &V| placed.distance(p), true);
        }
    }
    Grip { pose, object: placed, away }
}

fn settle(skeleton: &Skeleton, grasp: &Grasp, start: PlacedObject, chains: &[Chain; 5]) -> PlacedObject {
    let (palm, half) = palm_sheet(skeleton);
    let residuals = |unknowns: &SVector<f64, UNKNOWNS>| {
        let body = moved(&start, unknowns);
        let mut rows = SVector::<f64, ROWS>::zeros();
        let mut row = 0;
        let mut add = |value: f64| {
            rows[row] = value;
            row += 1;
        };
        for digit in Digit::ALL {
            let chain = &chains[digit as usize];
            let gaps: [f64; 3] = std::array::from_fn(|bone| gap(chain, bone, |p| body.distance(p)));
            let touches = grasp.touch.contains(&digit);
            add(if touches { gaps[2] / END_GAP } else { 0.0 });
            add(if touches { gaps[1] / MIDDLE_GAP } else { 0.0 });
            gaps.iter().for_each(|gap| add(gap.min(0.0) / INSIDE));
        }
        let in_palm = palm.iter().map(|p| body.distance(p) - half).fold(f64::INFINITY, f64::min);
        add(in_palm.min(0.0) / INSIDE);
        let scales = [PLACE, PLACE, PLACE, TILT, TILT, SIZE];
        unknowns.iter().zip(scales).for_each(|(unknown, scale)| add(unknown / scale));
        rows
    };
    let unknowns = FIT.fit(SVector::<f64, UNKNOWNS>::zeros(), residuals, |unknowns| unknowns);
    moved(&start, &unknowns)
}

fn moved(start: &PlacedObject, unknowns: &SVector<f64, UNKNOWNS>) -> PlacedObject {
    let tilt = start.turn * V::x() * unknowns[3] + start.turn * V::y() * unknowns[4];
    let turn = match Unit::try_new_and_get(tilt, 1e-12) {
        Some((axis, angle)) => UnitQuaternion::from_axis_angle(&axis, angle),
        None => UnitQuaternion::identity(),
    };
    let ratio = libm::exp(unknowns[5].clamp(-MOST_SCALED, MOST_SCALED));
    let object = match start.object {
        Object::Sphere { radius } => Object::Sphere { radius: radius * ratio },
        Object::Cylinder { radius, length } => Object::Cylinder { radius: radius * ratio, length },
    };
    PlacedObject {
        object,
        centre: start.centre + V::new(unknowns[0], unknowns[1], unknowns[2]),
        turn: turn * start.turn,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::{GraspSet, RecordedPose};
    use crate::hand::HandShape;

    #[test]
    fn recorded_hands_touch_what_they_are_given_and_do_not_go_deep() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let grasps = GraspSet::builtin();
        let (mut touching, mut deep, mut all) = (0, 0, 0);
        for recorded in RecordedPose::all() {
            let grasp = grasps.get(&recorded.grasp).expect("a grasp");
            let held = hold(&skeleton, grasp, grasp.object.object(0.5), &recorded.pose);
            let chains = skeleton.chains(&held.pose);
            for digit in &grasp.touch {
                let end = gap(&chains[*digit as usize], 2, |p| held.object.distance(p));
                all += 1;
                touching += usize::from(end.abs() < 0.005);
                deep += usize::from(end < -0.006);
            }
        }
        let share = |n: usize| n as f64 / all as f64;
        assert!(share(touching) > 0.9, "{touching} of {all} digits touch");
        assert!(share(deep) < 0.02, "{deep} of {all} digits go deep");
    }
}
