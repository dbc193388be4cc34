//! Closing the hand on an object.
//!
//! Each digit moves from its open toward its closed pose; a bone that meets the object stops, with
//! every joint before it, while the bones after it go on: so the fingers wrap any size of object. A
//! short least-squares fit then lays the end bones on the surface and takes every bone out of it.

use nalgebra::{SVector, Vector3};

use super::definition::{Grasp, Placement};
use super::least_squares::{Damping, LeastSquares};
use super::object::{Object, PlacedObject};
use crate::hand::{Chain, Digit, HandPose, JOINTS, Joints, Skeleton, joint_limits};

type V = Vector3<f64>;

/// How deep soft flesh gives way, in metres.
const PRESS: f64 = 0.0005;
/// How deep the ball of the thumb and the roots of the fingers give way.
const SOFT: f64 = 0.003;
/// A finger that ends further from the object than this has missed it, in metres.
const NEAR: f64 = 0.003;
/// Points looked at along each bone.
const SAMPLES: usize = 5;
const CLOSING_STEPS: usize = 90;
const FIT: LeastSquares =
    LeastSquares { damping: Damping::Even, start: 1e-2, rejected: 10.0, difference: 1e-4, steps: 30 };

/// A hand that holds an object.
#[derive(Debug, Clone)]
pub(crate) struct Grip {
    pub(crate) pose: HandPose,
    pub(crate) object: PlacedObject,
    /// The direction in which the object lies before it is grasped (unit length).
    pub(crate) away: V,
}

/// Closes a hand on an object in the way of a grasp.
pub(crate) fn grip(skeleton: &Skeleton, grasp: &Grasp, object: Object) -> Grip {
    let (placed, away, start) = match &grasp.object.placement {
        Placement::Palm { anchor, push } => {
            (against_palm(skeleton, grasp, object, *anchor, push), *push, grasp.open)
        }
        Placement::Tips { between } => between_tips(skeleton, grasp, object, between),
    };
    let mut pose = start;
    // The thumb comes last: it may lie over the fingers.
    let mut done: Vec<Chain> = Vec::new();
    for digit in Digit::FINGERS.into_iter().chain([Digit::Thumb]) {
        let obstacle = |p: &V| {
            let others = if digit == Digit::Thumb { done.as_slice() } else { &[] };
            others.iter().map(|c| c.distance(p, 0)).fold(placed.distance(p), f64::min)
        };
        let touch = grasp.touch.contains(&digit);
        let open = &start.digits[digit as usize];
        let closed = &grasp.closed.digits[digit as usize];
        let joints = close(skeleton, digit, open, closed, &obstacle);
        let mut joints = fit(skeleton, digit, joints, &placed, &obstacle, touch);
        let misses = gap(&skeleton.chain(digit, &joints), 2, |p| placed.distance(p)) > NEAR;
        if misses && grasp.follow.contains(&digit) {
            // All but the spread, which comes first.
            let neighbour = pose.digits[digit as usize - 1];
            joints[1..].copy_from_slice(&neighbour[1..]);
        }
        done.push(skeleton.chain(digit, &joints));
        pose.digits[digit as usize] = joints;
    }
    Grip { pose, object: placed, away }
}

/// The palm as a sheet of balls between the wrist and the knuckles: their centres and their radius.
pub(super) fn palm_sheet(skeleton: &Skeleton) -> (Vec<V>, f64) {
    let along = |finger| {
        let knuckle = skeleton.root(finger);
        (1..=8).map(move |i| knuckle.component_mul(&V::new(f64::from(i) / 8.0, 1.0, 1.0)))
    };
    (Digit::FINGERS.into_iter().flat_map(along).collect(), 0.47 * skeleton.shape().palm_thickness)
}

/// Pushes the object against the palm along a straight line.
pub(super) fn against_palm(
    skeleton: &Skeleton,
    grasp: &Grasp,
    object: Object,
    [x, y]: [f64; 2],
    push: &V,
) -> PlacedObject {
    let anchor = skeleton.palm_point([x, y, 0.0]);
    let (palm, half) = palm_sheet(skeleton);
    let place = |away: f64| PlacedObject::new(object, anchor + push * away, &grasp.object.axis);
    let clear = |away: f64| {
        let body = place(away);
        palm.iter().all(|p| body.distance(p) > half)
    };
    let (mut low, mut high) = (0.0, 0.3);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if clear(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    place(high)
}

/// Closes thumb and fingers together until their tips are as far apart as the object is wide, and
/// puts the object there. Gives the object, the direction away from the hand, and the pose reached.
fn between_tips(
    skeleton: &Skeleton,
    grasp: &Grasp,
    object: Object,
    between: &[Digit],
) -> (PlacedObject, V, HandPose) {
    let tips = |closure: f64| tips(between, &skeleton.chains(&grasp.open.toward(&grasp.closed, closure)));
    let flesh = |digit: Digit| skeleton.chain(digit, &grasp.open.digits[digit as usize]).radii[3];
    let wanted = 2.0 * object.radius() + flesh(Digit::Thumb) + flesh(between[0]);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let (thumb, fingers) = tips(middle);
        if (thumb - fingers).norm() > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let start = grasp.open.toward(&grasp.closed, low);
    let (placed, away) = between_tips_of(skeleton, grasp, object, between, &skeleton.chains(&start));
    (placed, away, start)
}

/// The thumb's tip, and the middle of the fingers' that oppose it.
fn tips(between: &[Digit], chains: &[Chain; 5]) -> (V, V) {
    let fingers = between.iter().map(|d| chains[*d as usize].points[3]).fold(V::zeros(), |sum, p| sum + p);
    (chains[0].points[3], fingers / between.len() as f64)
}

/// Puts the object between the tips of a posed hand; it shares the way that is left among them.
/// Returns the object and the direction away from the hand.
pub(super) fn between_tips_of(
    skeleton: &Skeleton,
    grasp: &Grasp,
    object: Object,
    between: &[Digit],
    chains: &[Chain; 5],
) -> (PlacedObject, V) {
    let flesh = |digit: Digit| chains[digit as usize].radii[3];
    let wanted = 2.0 * object.radius() + flesh(Digit::Thumb) + between.first().map_or(0.0, |d| flesh(*d));
    let (thumb, fingers) = tips(between, chains);
    let across = (fingers - thumb).try_normalize(1e-6).unwrap_or_else(V::x);
    // The disc's axis stands upright on the line between the tips.
    let axis = grasp.object.axis - across * across.dot(&grasp.object.axis);
    let axis = axis.try_normalize(1e-6).unwrap_or_else(V::z);
    let thumb_side = object.radius() + flesh(Digit::Thumb);
    let centre = thumb + across * thumb_side * ((fingers - thumb).norm() / wanted);
    let palm = skeleton.palm_point([0.5, 0.0, 0.0]);
    let away = (centre - palm).try_normalize(1e-6).unwrap_or_else(|| -V::z());
    (PlacedObject::new(object, centre, &axis), away)
}

/// The number of the bone that a joint moves first.
fn bone_of(digit: Digit, joint: usize) -> usize {
    match digit {
        Digit::Thumb => joint.saturating_sub(2),
        _ => joint.saturating_sub(1).min(2),
    }
}

/// Points along a bone with the flesh's radius there, without its first.
fn samples(chain: &Chain, bone: usize) -> impl Iterator<Item = (V, f64)> + '_ {
    (1..=SAMPLES).map(move |i| {
        let t = i as f64 / SAMPLES as f64;
        let (a, b) = (chain.points[bone], chain.points[bone + 1]);
        let radius = chain.radii[bone] + (chain.radii[bone + 1] - chain.radii[bone]) * t;
        (a + (b - a) * t, radius)
    })
}

/// How far a bone's flesh is from a surface; negative when it is inside.
pub(super) fn gap(chain: &Chain, bone: usize, surface: impl Fn(&V) -> f64) -> f64 {
    samples(chain, bone).map(|(p, r)| surface(&p) - r).fold(f64::INFINITY, f64::min)
}

fn close(
    skeleton: &Skeleton,
    digit: Digit,
    open: &Joints,
    closed: &Joints,
    obstacle: &impl Fn(&V) -> f64,
) -> Joints {
    let mut joints = *open;
    // Joints that move bones below this number have stopped.
    let mut stopped = 0;
    for _ in 0..CLOSING_STEPS {
        let mut next = joints;
        for joint in 0..JOINTS {
            if bone_of(digit, joint) >= stopped {
                next[joint] += (closed[joint] - open[joint]) / CLOSING_STEPS as f64;
            }
        }
        let chain = skeleton.chain(digit, &next);
        let met = (stopped..3).rev().find(|&bone| gap(&chain, bone, obstacle) < -PRESS);
        match met {
            Some(bone) => stopped = bone + 1,
            None => joints = next,
        }
        if stopped == 3 {
            break;
        }
    }
    joints
}

/// Fits a digit's joints: end bone on the surface, no bone in it, joints near where they were.
pub(super) fn fit(
    skeleton: &Skeleton,
    digit: Digit,
    start: Joints,
    object: &PlacedObject,
    obstacle: &impl Fn(&V) -> f64,
    touch: bool,
) -> Joints {
    const ROWS: usize = 1 + 3 + JOINTS;
    const MILLIMETRE: f64 = 1e-3;
    let limits = joint_limits(digit);
    let residuals = |joints: &SVector<f64, JOINTS>| {
        let chain = skeleton.chain(digit, joints.as_ref());
        let mut rows = SVector::<f64, ROWS>::zeros();
        if touch {
            rows[0] = (gap(&chain, 2, |p| object.distance(p)) + PRESS) / MILLIMETRE;
        }
        for bone in 0..3 {
            let give = if bone == 0 { SOFT } else { PRESS };
            rows[1 + bone] = (gap(&chain, bone, obstacle) + give).min(0.0) / MILLIMETRE;
        }
        for joint in 0..JOINTS {
            // Sideways moves and turns of the thumb's root look odd sooner than bending does.
            let stiff = if bone_of(digit, joint) == 0 && joint != 1 { 3.0 } else { 1.2 };
            rows[4 + joint] = (joints[joint] - start[joint]) * stiff;
        }
        rows
    };
    let limited = |joints: SVector<f64, JOINTS>| {
        joints.zip_map(&SVector::from(limits), |joint, [low, high]: [f64; 2]| joint.clamp(low, high))
    };
    FIT.fit(SVector::from(start), residuals, limited).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::GraspSet;
    use crate::hand::HandShape;

    /// Every hand shape with every object of every grasp: the digits that must touch do, none goes
    /// deep.
    #[test]
    fn every_hand_grips_every_object_cleanly() {
        let mut shapes = HandShape::presets();
        shapes.extend((0..4).map(HandShape::sample));
        let mut complaints = Vec::new();
        for shape in &shapes {
            let skeleton = Skeleton::new(shape);
            for grasp in &GraspSet::builtin() {
                for size in [0.0, 0.5, 1.0] {
                    let held = grip(&skeleton, grasp, grasp.object.object(size));
                    let chains = skeleton.chains(&held.pose);
                    for digit in Digit::ALL {
                        let chain = &chains[digit as usize];
                        let end = gap(chain, 2, |p| held.object.distance(p)) * 1e3;
                        let deepest = (0..3)
                            .map(|bone| gap(chain, bone, |p| held.object.distance(p)) * 1e3)
                            .fold(f64::INFINITY, f64::min);
                        let touches = grasp.touch.contains(&digit);
                        if touches && end.abs() > 3.0 || deepest < -4.5 {
                            complaints.push(format!(
                                "{} {} size {size}: {} end {end:.1} mm, deepest {deepest:.1} mm",
                                shape.name,
                                grasp.name,
                                digit.name()
                            ));
                        }
                    }
                }
            }
        }
        assert!(complaints.is_empty(), "{} of them:\n{}", complaints.len(), complaints.join("\n"));
    }

    #[test]
    fn only_thumb_and_index_touch_what_is_pinched() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let set = GraspSet::builtin();
        let pinch = set.get("pinch").expect("pinch");
        let held = grip(&skeleton, pinch, pinch.object.object(0.5));
        let chains = skeleton.chains(&held.pose);
        for digit in [Digit::Middle, Digit::Ring, Digit::Little] {
            let near = (0..3)
                .map(|bone| gap(&chains[digit as usize], bone, |p| held.object.distance(p)))
                .fold(f64::INFINITY, f64::min);
            assert!(near > 0.003, "{}: {near}", digit.name());
        }
    }
}
