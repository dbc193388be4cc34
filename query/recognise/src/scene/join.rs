//! What the networks of scenes say, together with what the neighbours say: a logarithmic opinion
//! pool, the product of both's probabilities, each to a power.

use grasp_index::{ClassScore, Index, OrientationEstimate, Vote};
use nalgebra::UnitQuaternion;

use super::prediction::Powers;
use super::{Opening, Prediction};
use crate::networks::GRASP;
use crate::orientation::join_near;
use crate::side::{HandChoice, Side};

/// Probabilities below this count as this: neither side is so sure.
const PROBABILITY_FLOOR: f64 = 1e-3;

/// How much of an orientation is what networks see of it. Chosen on pictures of two hands
/// (docs/trials.md).
const SEEN: f64 = 0.4;

impl Prediction {
    /// Weighs the neighbours' classes and stages by what the networks make of hand and object.
    /// Classes that they do not know count as their mean. `side` is the hand that was asked for, or
    /// the likelier one. Returns how likely the hand is in none of the grasps.
    pub(crate) fn join(&self, index: &Index, side: Side, asked: HandChoice, vote: &mut Vote) -> f64 {
        let probabilities = match asked {
            HandChoice::Auto => self.probabilities_of_likelier(side),
            HandChoice::Left | HandChoice::Right => self.probabilities(side),
        };
        let (no_grasp, grasps) = probabilities.split_last().expect("the last is no grasp");
        let known: f64 = grasps.iter().sum();
        let of_name = |name: &str| {
            let at = self.grasps.iter().position(|grasp| grasp == name);
            at.map_or(1.0 / grasps.len() as f64, |at| grasps[at] / known.max(PROBABILITY_FLOOR))
        };
        let name = |class: u16| index.catalogue().classes.get(usize::from(class)).map(|c| c.name.as_str());
        let by_scene = |class: u16| name(class).map_or(0.0, of_name);
        let both = vote.classes.iter().map(|score| (score.probability, by_scene(score.class)));
        let (mut joined, no_grasp) = joined(&both.collect::<Vec<_>>(), *no_grasp, self.powers);
        if let Some(stages) = &mut vote.stages {
            *stages = joined_stages(stages, &self.stages(side));
            let open = self.powers.opening * (1.0 - stages[GRASP]);
            let opening = Opening::built_in();
            let names = vote.classes.iter().map(|score| name(score.class).unwrap_or_default());
            let factors = names.map(|name| libm::exp(opening.log_odds(name, open)));
            joined.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
        }
        let total: f64 = joined.iter().sum();
        vote.classes.iter_mut().zip(joined).for_each(|(score, value)| score.probability = value / total);
        ClassScore::rank(&mut vote.classes);
        no_grasp
    }
}

/// Moves the orientation of a hand in the picture towards the rotations near it that networks see.
pub(crate) fn join_orientation(seen: &[UnitQuaternion<f64>], orientation: &mut OrientationEstimate) {
    join_near(orientation, seen, |_| SEEN);
}

/// The probability of each stage by neighbours and networks.
fn joined_stages<const N: usize>(neighbours: &[f64; N], networks: &[f64; N]) -> [f64; N] {
    let both: [f64; N] = std::array::from_fn(|stage| {
        neighbours[stage].max(PROBABILITY_FLOOR) * networks[stage].max(PROBABILITY_FLOOR)
    });
    let total: f64 = both.iter().sum();
    both.map(|value| value / total)
}

/// The probability of each class, if it is one of them, and that of none: from the neighbours' and
/// the networks' probabilities of the classes, and the networks' of none, of which the neighbours
/// know nothing: to them it is as likely as any class.
fn joined(classes: &[(f64, f64)], no_grasp: f64, powers: Powers) -> (Vec<f64>, f64) {
    let power = |value: f64, power: f64| libm::pow(value.max(PROBABILITY_FLOOR), power);
    let both = classes.iter().map(|&(n, s)| power(n, powers.neighbours) * power(s, powers.networks));
    let mut joined: Vec<f64> = both.collect();
    let total: f64 = joined.iter().sum();
    let even = libm::pow(1.0 / classes.len().max(1) as f64, powers.neighbours);
    let of_no_grasp = even * power(no_grasp, powers.networks);
    let of_grasps = total * libm::pow(1.0 - no_grasp, powers.networks);
    joined.iter_mut().for_each(|value| *value /= total);
    (joined, of_no_grasp / (of_no_grasp + of_grasps))
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_index::euler_deg;

    const POWERS: Powers = Powers { neighbours: 0.7, networks: 1.2, opening: 0.0 };

    #[test]
    fn what_is_seen_near_an_orientation_moves_it_and_what_is_far_does_not() {
        let about_z = |degrees: f64| UnitQuaternion::from_euler_angles(0.0, 0.0, degrees.to_radians());
        let moved = |seen: &[f64]| {
            let seen: Vec<_> = seen.iter().map(|degrees| about_z(*degrees)).collect();
            let rotation = about_z(10.0);
            let mut moved =
                OrientationEstimate { rotation, euler_deg: euler_deg(&rotation), spread_deg: 5.0 };
            join_orientation(&seen, &mut moved);
            moved.rotation.angle_to(&rotation).to_degrees()
        };
        assert!(moved(&[]).abs() < 1e-9 && moved(&[60.0, 190.0]).abs() < 1e-9);
        assert!((moved(&[20.0]) - 10.0 * SEEN).abs() < 0.1, "{}", moved(&[20.0]));
        assert!((moved(&[20.0, 190.0]) - moved(&[20.0])).abs() < 1e-9);
        assert!((moved(&[0.0, 20.0])).abs() < 1e-9);
    }

    #[test]
    fn both_are_multiplied() {
        let (classes, no_grasp) = joined(&[(0.7, 0.2), (0.2, 0.7), (0.1, 0.1)], 0.05, POWERS);
        assert!((classes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // The networks count for more.
        assert!(classes[1] > classes[0] && classes[0] > classes[2], "{classes:?}");
        assert!(no_grasp < 0.05, "{no_grasp}");
    }

    #[test]
    fn stages_are_multiplied_and_none_is_impossible() {
        let stages = joined_stages(&[0.5, 0.25, 0.25], &[0.2, 0.0, 0.8]);
        assert!((stages.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(stages[2] > stages[0] && stages[0] > stages[1] && stages[1] > 0.0, "{stages:?}");
    }

    #[test]
    fn none_is_likely_where_networks_say_so_and_neighbours_do_not_contradict() {
        let of = |neighbours: [f64; 3], no_grasp: f64| {
            joined(&neighbours.map(|n| (n, 1.0 / 3.0)), no_grasp, POWERS).1
        };
        let (sure, unsure) = ([0.98, 0.01, 0.01], [1.0 / 3.0; 3]);
        // To neighbours that know nothing it is one class of four.
        let even = of(unsure, 0.25);
        assert!((even - 1.0 / (1.0 + 3.0)).abs() < 1e-9, "{even}");
        assert!(of(unsure, 0.9) > of(unsure, 0.6) && of(unsure, 0.6) > even);
        assert!(of([1.0; 3].map(|n| n / 3.0), 1.0) > 0.999 && of(sure, 0.0) < 0.01);
    }
}
