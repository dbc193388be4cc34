//! What a hand's skin has where: nails, knuckles, and the palm's side of every digit.
//!
//! The palm's skin has another colour than the back's, nails are pale and shine, knuckles are red
//! or dark. By these a person knows the back of a hand from its palm where the outlines are alike.

use nalgebra::Vector3;

use crate::hand::Chain;
use crate::mesh::Mesh;

type V = Vector3<f64>;

/// A place that is further from the flesh of every digit than this, in metres, is on the palm or
/// the back of the hand.
const ON_DIGIT: f64 = 0.004;
/// Where a nail begins and ends along the end bone, in shares of the bone and of the tip's radius;
/// how wide it is in shares of the radius, and how far round it goes.
const NAIL_FROM: f64 = 0.45;
const NAIL_TO: f64 = 0.75;
const NAIL_WIDE: f64 = 0.75;
const NAIL_FACING: f64 = 0.45;
/// How far from its joint a knuckle goes, in radii of the flesh there.
const KNUCKLE: f64 = 0.8;

/// What the skin has at a place.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Mark {
    /// How far the skin faces to the palm's side, 1, or to the nail's, -1.
    pub(super) palmar: f32,
    /// 1 on a nail, 0 beside it.
    pub(super) nail: f32,
    /// 1 in the middle of a knuckle, 0 away from it.
    pub(super) knuckle: f32,
}

/// The marks of every vertex of a posed hand.
pub(super) fn marks(hand: &Mesh, chains: &[Chain; 5]) -> Vec<Mark> {
    hand.vertices.iter().zip(&hand.normals).map(|(p, n)| mark(&p.cast(), &n.cast(), chains)).collect()
}

fn mark(p: &V, normal: &V, chains: &[Chain; 5]) -> Mark {
    let bones = chains.iter().flat_map(|chain| (0..3).map(move |bone| (chain, bone)));
    let nearest = bones
        .map(|(chain, bone)| (chain, bone, chain.bone_distance(p, bone).abs()))
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .filter(|(.., distance)| *distance < ON_DIGIT);
    let Some((chain, bone, _)) = nearest else {
        return Mark { palmar: -normal.z as f32, ..Mark::default() };
    };
    let [from, to] = [chain.points[bone], chain.points[bone + 1]];
    let long = (to - from).norm();
    let along = (to - from) / long;
    let last = (chain.points[3] - chain.points[2]).normalize();
    let axis = chain.nail.cross(&last);
    let nailward = along.cross(&axis);
    let facing = normal.dot(&nailward);
    let at = (p - from).dot(&along);
    let radius = chain.radii[bone + 1];
    let is_nail = bone == 2
        && (NAIL_FROM * long..long + NAIL_TO * radius).contains(&at)
        && (p - from).dot(&axis).abs() < NAIL_WIDE * radius
        && facing > NAIL_FACING;
    // The joint at the bone's end, and the one at its beginning.
    let joints = [(long, bone < 2), (0.0, true)];
    let near = joints.iter().filter(|(_, is_joint)| *is_joint).map(|(joint, _)| (at - joint).abs());
    let near = near.fold(f64::INFINITY, f64::min) / (KNUCKLE * radius);
    Mark {
        palmar: -facing as f32,
        nail: if is_nail { 1.0 } else { 0.0 },
        knuckle: ((1.0 - near).max(0.0) * facing.max(0.0)) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Preset, RenderPlan};
    use crate::scene::Pieces;

    #[test]
    fn nails_are_on_the_far_ends_and_the_palm_faces_down() {
        // Fingers that a ball holds apart.
        let specs = RenderPlan::preset(Preset::Paper).scenes();
        for spec in &specs {
            let Pieces { hand, chains, .. } = spec.pieces();
            let marks = marks(&hand, &chains);
            assert_eq!(marks.len(), hand.vertices.len());
            for chain in &chains {
                let nail = chain.points[3] + chain.nail * chain.radii[3];
                let near = |v: &V, metres: f64| (v - nail).norm() < metres;
                let on = hand.vertices.iter().zip(&marks).filter(|(v, _)| near(&v.cast(), 0.004));
                let (count, nails) = on.fold((0, 0), |(count, nails), (_, mark)| {
                    (count + 1, nails + usize::from(mark.nail > 0.0 && mark.palmar < 0.0))
                });
                assert!(count > 0 && 4 * nails >= 3 * count, "{}: {nails} of {count}", spec.grasp.name);
            }
            let share = marks.iter().filter(|mark| mark.nail > 0.0).count() as f64 / marks.len() as f64;
            assert!((0.005..0.06).contains(&share), "{}: nails are {share} of the skin", spec.grasp.name);
            let wrist = hand.vertices.iter().zip(&marks).filter(|(v, _)| (0.0..0.012).contains(&v.x));
            assert!(wrist.clone().all(|(_, mark)| mark.nail == 0.0));
            let back = wrist.filter(|(v, _)| v.z > 0.012).map(|(_, mark)| mark.palmar);
            assert!(back.fold(f32::MIN, f32::max) < 0.0);
        }
    }
}
