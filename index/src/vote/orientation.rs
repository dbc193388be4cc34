//! Equation 4: the mean orientation of the neighbours of the chosen class, weighted as in Equation
//! 3.
//!
//! The mean is one of rotations: F. L. Markley, Y. Cheng, J. L. Crassidis, Y. Oshman, *Averaging
//! Quaternions*, Journal of Guidance, Control, and Dynamics 30(4), 2007. A mean of Euler angles
//! breaks near the poles; it is kept as an option, so that the paper's own figures can be repeated.
//!
//! Neighbours may agree on two orientations, as a hand seen from the front is like one seen from
//! behind, and the mean of both is nobody's. The mean is therefore taken over the greatest cluster
//! alone: of all neighbours the one with the most weight within [`CLUSTER_DEG`] degrees, and those.
//! The literal form takes all.

use super::ballot::Ballot;
use super::class::relative_weights;
use crate::rotation::{euler_deg, from_euler_deg};
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector4};

/// How far from its centre a cluster reaches. On development pictures whose neighbours disagree by
/// more than 45 degrees (8 in 100), the median error falls from 23 to 13 degrees; 20 and 60 degrees
/// do no better.
const CLUSTER_DEG: f64 = 40.0;

/// How much the opinions of a network count together, in all weights of neighbours.
const OPINIONS: f64 = 1.0;

/// An orientation with its spread.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationEstimate {
    /// `camera_from_hand`.
    pub rotation: UnitQuaternion<f64>,
    /// The same as [`euler_deg`] gives it: degrees about the fixed axes x, y, z.
    pub euler_deg: [f64; 3],
    /// The weighted root mean square angle between all neighbours of the class and the estimate, in
    /// degrees: 0 where they agree, 180 where nothing is known.
    pub spread_deg: f64,
}

/// The orientation of class `class`: what its ballots say, and opinions that did not come from
/// neighbours, which together count [`OPINIONS`] times as much as the ballots do; the literal form
/// leaves them out. Without any: the identity. Without orientations of ballots, the spread is 180
/// degrees.
pub(crate) fn estimate(
    ballots: &[Ballot],
    opinions: &[UnitQuaternion<f64>],
    class: u16,
    sigma: f64,
    euler_mean: bool,
) -> OrientationEstimate {
    let same: Vec<Ballot> = ballots.iter().filter(|ballot| ballot.class == class).copied().collect();
    let weights = relative_weights(same.iter().map(|ballot| ballot.distance), sigma);
    let weighed = same.iter().zip(weights);
    let rotations: Vec<_> =
        weighed.filter_map(|(ballot, weight)| Some((ballot.orientation?, weight))).collect();
    let mean = if euler_mean {
        cyclic_euler_mean(&rotations)
    } else {
        let all: f64 = rotations.iter().map(|(_, weight)| weight).sum();
        // Without a neighbour they are all that there is.
        let each = OPINIONS * if all > 0.0 { all } else { 1.0 } / opinions.len().max(1) as f64;
        let opinions = opinions.iter().map(|opinion| (*opinion, each));
        mean_rotation(&greatest_cluster(&rotations.iter().copied().chain(opinions).collect::<Vec<_>>()))
    };
    let Some(rotation) = mean else {
        return OrientationEstimate {
            rotation: UnitQuaternion::identity(),
            euler_deg: [0.0; 3],
            spread_deg: 180.0,
        };
    };
    let (mut squares, mut sum) = (0.0, 0.0);
    for (neighbour, weight) in &rotations {
        squares += weight * neighbour.angle_to(&rotation).powi(2);
        sum += weight;
    }
    OrientationEstimate {
        rotation,
        euler_deg: euler_deg(&rotation),
        spread_deg: if sum > 0.0 { (squares / sum).sqrt().to_degrees() } else { 180.0 },
    }
}

/// The rotations around the one that has the most weight near it; the first of equals.
fn greatest_cluster(rotations: &[(UnitQuaternion<f64>, f64)]) -> Vec<(UnitQuaternion<f64>, f64)> {
    // Of q and -q, the same rotation, the nearer one counts.
    let least = libm::cos((CLUSTER_DEG / 2.0).to_radians());
    let around = |centre: UnitQuaternion<f64>| {
        rotations.iter().filter(move |(other, _)| other.coords.dot(&centre.coords).abs() >= least)
    };
    let weight = |centre| around(centre).map(|(_, weight)| weight).sum::<f64>();
    let weights = rotations.iter().map(|&(centre, _)| (centre, weight(centre)));
    let greatest = weights.min_by(|(_, a), (_, b)| b.total_cmp(a));
    greatest.map_or_else(Vec::new, |(centre, _)| around(centre).copied().collect())
}

/// The weighted mean of rotations: the eigenvector of `sum w q q^T` with the greatest eigenvalue. q
/// and -q, the same rotation, count the same. Its sign is chosen so that w >= 0. `None` where the
/// weights sum to nothing.
pub fn mean_rotation(rotations: &[(UnitQuaternion<f64>, f64)]) -> Option<UnitQuaternion<f64>> {
    let mut sum = Matrix4::zeros();
    for (rotation, weight) in rotations {
        let q: Vector4<f64> = rotation.coords;
        sum += *weight * q * q.transpose();
    }
    if !(sum.trace() > 0.0 && sum.trace().is_finite()) {
        return None;
    }
    let eigen = (sum / sum.trace()).try_symmetric_eigen(f64::EPSILON, 1000)?;
    let (greatest, _) = eigen.eigenvalues.argmax();
    let q = Quaternion::from(eigen.eigenvectors.column(greatest).into_owned());
    Some(UnitQuaternion::new_normalize(if q.w < 0.0 { -q } else { q }))
}

/// Equation 4 as printed: the weighted mean of each Euler angle by itself, on the circle. `None`
/// where the weights sum to nothing.
fn cyclic_euler_mean(rotations: &[(UnitQuaternion<f64>, f64)]) -> Option<UnitQuaternion<f64>> {
    let sum: f64 = rotations.iter().map(|(_, weight)| weight).sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let mut circles = [(0.0, 0.0); 3];
    for (rotation, weight) in rotations {
        for (circle, angle) in circles.iter_mut().zip(euler_deg(rotation)) {
            let (sin, cos) = libm::sincos(angle.to_radians());
            circle.0 += weight * sin;
            circle.1 += weight * cos;
        }
    }
    Some(from_euler_deg(circles.map(|(sin, cos)| libm::atan2(sin, cos).to_degrees())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn turn(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(axis.normalize() * degrees.to_radians())
    }

    #[test]
    fn two_turns_about_one_axis_average_to_the_turn_between() {
        let mean = mean_rotation(&[(turn(Vector3::z(), 10.0), 1.0), (turn(Vector3::z(), 50.0), 1.0)]);
        assert!(mean.unwrap().angle_to(&turn(Vector3::z(), 30.0)) < 1e-9);
    }

    #[test]
    fn the_mean_crosses_the_half_turn() {
        let rotations = [(turn(Vector3::z(), 170.0), 1.0), (turn(Vector3::z(), -170.0), 1.0)];
        let half = turn(Vector3::z(), 180.0);
        assert!(mean_rotation(&rotations).unwrap().angle_to(&half) < 1e-9);
        assert!(cyclic_euler_mean(&rotations).unwrap().angle_to(&half) < 1e-9);
    }

    #[test]
    fn near_a_pole_the_literal_form_breaks_and_the_mean_does_not() {
        // 3 degrees apart, on both sides of the pole. The angles' own means are 89.5 and -89.5,
        // half a turn off.
        let rotations =
            [(from_euler_deg([0.0, 89.0, 0.0]), 1.0), (from_euler_deg([179.0, 89.0, -179.0]), 1.0)];
        let pole = from_euler_deg([0.0, 90.0, 1.0]);
        let off = |mean: Option<UnitQuaternion<f64>>| mean.unwrap().angle_to(&pole).to_degrees();
        assert!(off(mean_rotation(&rotations)) < 1.0);
        assert!(off(cyclic_euler_mean(&rotations)) > 90.0);
    }

    proptest! {
        #[test]
        fn the_sign_of_a_quaternion_does_not_matter(
            turns in prop::collection::vec(([-1.0..1.0f64, -1.0..1.0, -1.0..1.0], 0.1..1.0f64, any::<bool>()), 1..8)
        ) {
            let rotations: Vec<_> = turns
                .iter()
                .map(|(v, w, _)| (UnitQuaternion::from_scaled_axis(Vector3::from(*v)), *w))
                .collect();
            let flipped: Vec<_> = rotations
                .iter()
                .zip(&turns)
                .map(|((q, w), (_, _, flip))| (if *flip { UnitQuaternion::new_unchecked(-q.into_inner()) } else { *q }, *w))
                .collect();
            let (mean, same) = (mean_rotation(&rotations).unwrap(), mean_rotation(&flipped).unwrap());
            prop_assert!(mean.angle_to(&same) < 1e-7);
            prop_assert!(mean.w >= 0.0);
        }

        #[test]
        fn the_mean_of_one_rotation_is_itself(v in [-3.0..3.0f64, -3.0..3.0, -3.0..3.0], w in 1e-9..1.0f64) {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(v));
            prop_assert!(mean_rotation(&[(rotation, w)]).unwrap().angle_to(&rotation) < 1e-7);
        }
    }

    #[test]
    fn of_two_orientations_the_weightier_is_taken_and_the_spread_tells_of_both() {
        let ballot =
            |degrees, distance| Ballot { class: 0, distance, orientation: Some(turn(Vector3::y(), degrees)) };
        // Three about 10 degrees, and the nearest of all, alone, on the other side.
        let ballots = [ballot(180.0, 0.9), ballot(0.0, 1.0), ballot(10.0, 1.0), ballot(20.0, 1.0)];
        let found = estimate(&ballots, &[], 0, 1.0, false);
        assert!(found.rotation.angle_to(&turn(Vector3::y(), 10.0)) < 1e-6, "{found:?}");
        assert!((80.0..100.0).contains(&found.spread_deg), "{found:?}");
        let agreed = estimate(&ballots[1..], &[], 0, 1.0, false);
        assert!((agreed.spread_deg - (200.0f64 / 3.0).sqrt()).abs() < 1e-6, "{agreed:?}");
    }

    #[test]
    fn opinions_count_as_much_as_neighbours_and_without_any_alone() {
        let ballot =
            |degrees| Ballot { class: 0, distance: 1.0, orientation: Some(turn(Vector3::y(), degrees)) };
        let opinions = [turn(Vector3::y(), 30.0); 3];
        let both = estimate(&[ballot(8.0), ballot(12.0)], &opinions, 0, 1.0, false);
        assert!(both.rotation.angle_to(&turn(Vector3::y(), 20.0)) < 1e-2, "{both:?}");
        assert!(both.spread_deg < 13.0, "of the neighbours: {both:?}");
        let literal = estimate(&[ballot(8.0), ballot(12.0)], &opinions, 0, 1.0, true);
        assert!(literal.rotation.angle_to(&turn(Vector3::y(), 10.0)) < 1e-2, "{literal:?}");
        let alone = estimate(&[ballot(0.0)], &opinions, 1, 1.0, false);
        assert!(alone.rotation.angle_to(&opinions[0]) < 1e-6 && alone.spread_deg == 180.0, "{alone:?}");
    }

    #[test]
    fn what_is_farther_than_a_cluster_reaches_does_not_move_the_mean() {
        let ballot =
            |degrees| Ballot { class: 0, distance: 1.0, orientation: Some(turn(Vector3::y(), degrees)) };
        // 70 degrees are within 40 of none of the others.
        let found = estimate(&[0.0, 10.0, 20.0, 70.0].map(ballot), &[], 0, 1.0, false);
        assert!(found.rotation.angle_to(&turn(Vector3::y(), 10.0)) < 1e-6, "{found:?}");
    }

    #[test]
    fn the_literal_mean_is_weighted_on_the_circle() {
        let rotations = [(turn(Vector3::z(), 10.0), 0.5), (turn(Vector3::z(), 130.0), 0.25)];
        let found = cyclic_euler_mean(&rotations).unwrap();
        // Sides of 2 and 1, 120 degrees apart, sum to one that is 30 degrees off the longer.
        assert!(found.angle_to(&turn(Vector3::z(), 40.0)) < 1e-9, "{found:?}");
    }

    #[test]
    fn nothing_has_no_mean() {
        assert_eq!(mean_rotation(&[]), None);
        assert_eq!(cyclic_euler_mean(&[(UnitQuaternion::identity(), 0.0)]), None);
        let estimate = estimate(&[], &[], 0, 1.0, false);
        assert_eq!(estimate.spread_deg, 180.0);
    }
}
