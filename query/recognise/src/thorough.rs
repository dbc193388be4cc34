//! Test-time augmentation: a picture looked at in several variants ([`Variant`]), and what all of
//! them say together.

use grasp_index::{ClassScore, NETWORK_STAGES, OrientationEstimate, Vote};
use nalgebra::UnitQuaternion;

use crate::hypothesis::Hypothesis;
use crate::orientation::join_near;
use crate::segment::Mask;
use crate::side::Side;
use crate::variant::Variant;

/// The variants beside the picture as it is. Each costs as much time as that.
pub(crate) const VARIANTS: [Variant; 8] = [
    Variant::Mirrored,
    Variant::TurnedRight,
    Variant::TurnedLeft,
    Variant::Darker,
    Variant::Brighter,
    Variant::Warmer,
    Variant::Colder,
    Variant::Enlarged,
];

/// Probabilities below this count as this: one variant that rules a class out must not decide
/// alone.
const PROBABILITY_FLOOR: f64 = 1e-4;

/// What one variant of a picture says, of the hand as it is.
#[derive(Debug)]
pub(crate) struct VariantAnswer {
    side: Side,
    /// By class number.
    classes: Vec<(u16, f64)>,
    stages: Option<[f64; NETWORK_STAGES.len()]>,
    rotation: UnitQuaternion<f64>,
    no_grasp: Option<f64>,
}

impl VariantAnswer {
    /// By the likeliest hypothesis about a picture of this variant.
    pub(crate) fn new(variant: Variant, best: &Hypothesis, no_grasp: Option<f64>) -> Self {
        Self {
            side: variant.side(best.side),
            classes: best.vote.classes.iter().map(|class| (class.class, class.probability)).collect(),
            stages: best.vote.stages,
            rotation: variant.orientation_as_it_is(&best.vote.orientation.rotation),
            no_grasp,
        }
    }
}

/// Whether most of all, the picture as it is among them, show the other hand than that one does.
pub(crate) fn most_show_other(own: Side, others: &[VariantAnswer]) -> bool {
    let against = others.iter().filter(|said| said.side != own).count();
    2 * against > others.len() + 1
}

/// Joins what other variants say of a hand with what is said of the picture as it is: the geometric
/// mean of the classes' probabilities, normalised, and the mean of those of the stages. Returns how
/// likely the hand is in none of the grasps.
pub(crate) fn join(others: &[VariantAnswer], vote: &mut Vote, no_grasp: Option<f64>) -> Option<f64> {
    join_classes(others, &mut vote.classes);
    if let Some(stages) = &mut vote.stages {
        let said: Vec<_> = others.iter().filter_map(|said| said.stages).collect();
        for (at, stage) in stages.iter_mut().enumerate() {
            *stage = (*stage + said.iter().map(|said| said[at]).sum::<f64>()) / (said.len() + 1) as f64;
        }
    }
    let predicted = || others.iter().filter_map(|said| said.no_grasp);
    no_grasp.map(|no_grasp| (no_grasp + predicted().sum::<f64>()) / (predicted().count() + 1) as f64)
}

/// How variants that show this hand have it turned in the picture as it is.
pub(crate) fn rotations(others: &[VariantAnswer], side: Side) -> Vec<UnitQuaternion<f64>> {
    others.iter().filter(|said| said.side == side).map(|said| said.rotation).collect()
}

/// Makes an orientation the mean of itself and of the rotations near it, each counting as much.
pub(crate) fn join_orientation(rotations: &[UnitQuaternion<f64>], orientation: &mut OrientationEstimate) {
    join_near(orientation, rotations, |near| near as f64 / (near + 1) as f64);
}

/// Whether two masks of one picture are of the same hand: each of two hands, or of a hand and
/// something else, lies beside the other.
pub(crate) fn is_same_hand(one: &Mask, other: &Mask) -> bool {
    2 * one.and(other).area() >= one.area().min(other.area())
}

fn join_classes(others: &[VariantAnswer], classes: &mut [ClassScore]) {
    for class in &mut *classes {
        let said = others.iter().map(|said| {
            let own = said.classes.iter().find(|(number, _)| *number == class.class);
            own.map_or(PROBABILITY_FLOOR, |(_, probability)| probability.max(PROBABILITY_FLOOR))
        });
        let logs = libm::log(class.probability.max(PROBABILITY_FLOOR)) + said.map(libm::log).sum::<f64>();
        class.probability = libm::exp(logs / (others.len() + 1) as f64);
    }
    let total: f64 = classes.iter().map(|class| class.probability).sum();
    classes.iter_mut().for_each(|class| class.probability /= total);
    ClassScore::rank(classes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::side::HandChoice;
    use grasp_index::euler_deg;

    fn about_z(degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(0.0, 0.0, degrees.to_radians())
    }

    fn said(side: Side, probabilities: [f64; 3], degrees: f64) -> VariantAnswer {
        let classes = (0u16..).zip(probabilities).collect();
        VariantAnswer { side, classes, stages: None, rotation: about_z(degrees), no_grasp: None }
    }

    fn scores(probabilities: [f64; 3]) -> Vec<ClassScore> {
        let score = |(class, probability): (u16, f64)| ClassScore {
            class,
            name: String::new(),
            cutkosky: 0,
            probability,
            share: 0.0,
        };
        (0u16..).zip(probabilities).map(score).collect()
    }

    #[test]
    fn classes_are_those_that_all_variants_find_likely() {
        let mut classes = scores([0.6, 0.4, 0.0]);
        join_classes(&[], &mut classes);
        assert_eq!(classes.iter().map(|class| class.class).collect::<Vec<_>>(), [0, 1, 2]);
        assert!((classes[0].probability - 0.6).abs() < 1e-3);
        // Two variants of three find the second likelier, and one of them excludes the first.
        let others = [[0.4, 0.5, 0.1], [0.0, 0.5, 0.5]].map(|classes| said(Side::Right, classes, 0.0));
        join_classes(&others, &mut classes);
        assert_eq!(classes[0].class, 1);
        assert!((classes.iter().map(|class| class.probability).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(classes.iter().all(|class| class.probability > 0.0), "{classes:?}");
    }

    #[test]
    fn most_may_show_the_other_hand_and_a_hand_is_turned_as_those_near_say() {
        let [left, right] = [Side::Left, Side::Right].map(|side| said(side, [1.0, 0.0, 0.0], 20.0));
        assert!(!most_show_other(Side::Right, &[]));
        assert!(!most_show_other(Side::Left, std::slice::from_ref(&right)));
        let others = [right, said(Side::Right, [1.0, 0.0, 0.0], 100.0), left];
        assert!(most_show_other(Side::Left, &others[..2]));
        assert!(!most_show_other(Side::Left, &others));
        // One is near and of the same hand, one is far off, one is of the other hand.
        let of_right = rotations(&others, Side::Right);
        assert_eq!(of_right, [20.0, 100.0].map(about_z));
        let rotation = about_z(10.0);
        let mut joined = OrientationEstimate { rotation, euler_deg: euler_deg(&rotation), spread_deg: 5.0 };
        join_orientation(&of_right, &mut joined);
        assert!(joined.rotation.angle_to(&about_z(15.0)) < 1e-9, "{joined:?}");
        assert_eq!((joined.euler_deg, joined.spread_deg), (euler_deg(&joined.rotation), 5.0));
    }

    #[test]
    fn masks_are_of_the_same_hand_where_they_overlap() {
        let columns = |from: usize, to: usize| {
            let values: Vec<usize> = (0..200).collect();
            Mask::from_values(20, 10, &values, move |at: usize| (from..to).contains(&(at % 20)))
        };
        // The whole hand and some of the table; half of the hand; another hand beside it.
        assert!(is_same_hand(&columns(0, 8), &columns(0, 16)));
        assert!(is_same_hand(&columns(0, 8), &columns(4, 12)));
        assert!(!is_same_hand(&columns(0, 8), &columns(6, 14)));
    }

    #[test]
    fn what_is_said_of_a_variant_is_about_the_picture_as_it_is() {
        let rotation = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.1);
        for variant in Variant::ALL {
            let there = variant.orientation(&rotation);
            assert!(variant.orientation_as_it_is(&there).angle_to(&rotation) < 1e-9, "{}", variant.name());
            assert_eq!(variant.side(variant.side(Side::Left)), Side::Left, "{}", variant.name());
            let mirrors = variant.side(Side::Left) == Side::Right;
            let hand = if mirrors { HandChoice::Right } else { HandChoice::Left };
            assert_eq!(variant.hand(HandChoice::Left), hand, "{}", variant.name());
        }
        assert!(!VARIANTS.contains(&Variant::AsItIs));
    }
}
