//! Fitting a model of trust: a mixture of what neighbours say and of no knowledge, by expectation
//! maximisation.

use nalgebra::{DMatrix, DVector};

use grasp_recognise::{Evidence, Logistic, Term, logistic};

/// Rounds of expectation and maximisation: the likelihood no longer changes in its fifth digit.
const ROUNDS: usize = 300;
/// What a weight costs: half its square times this, against the sum of logarithms.
const RIDGE: f64 = 2.0;

/// What a model is fitted to: one picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Example {
    pub(super) measures: [Option<f64>; Evidence::NAMES.len()],
    /// The labelled class's probability by the neighbours; 0 where the picture shows none of the
    /// classes.
    pub(super) labelled: f64,
    /// The same without knowledge of the picture; 1 where it shows none of the classes.
    pub(super) unknowing: f64,
    /// How much it counts.
    pub(super) weight: f64,
}

/// Measures that can only speak against a hand, the more the larger they are, and such as can only
/// speak for it. A few hundred pictures may say otherwise by chance, and a model that believed them
/// would trust what is like nothing that it has seen.
const AGAINST: [&str; 4] = ["skin_around", "on_border", "nearest", "spread"];
const FOR: [&str; 3] = ["scene_side", "scene_agrees", "scene_sure"];

/// The model under which the labels are likeliest, of those in which no measure speaks for what it
/// cannot.
pub(super) fn fit(examples: &[Example]) -> Logistic {
    let mut left_out = [false; Evidence::NAMES.len()];
    loop {
        let model = fit_to(examples, &left_out);
        let mut is_sound = true;
        for (name, left_out) in Evidence::NAMES.iter().zip(&mut left_out) {
            let weight = model.measures[*name].weight;
            if AGAINST.contains(name) && weight > 0.0 || FOR.contains(name) && weight < 0.0 {
                (*left_out, is_sound) = (true, false);
            }
        }
        if is_sound {
            return model;
        }
    }
}

/// The likeliest model by the measures that are not left out.
fn fit_to(examples: &[Example], left_out: &[bool; Evidence::NAMES.len()]) -> Logistic {
    let terms: Vec<Term> = (0..Evidence::NAMES.len()).map(|at| term(examples, at)).collect();
    let columns = terms.len() + 1;
    let standard = DMatrix::from_fn(examples.len(), columns, |row, column| match column.checked_sub(1) {
        None => 1.0,
        Some(at) if left_out[at] => 0.0,
        Some(at) => {
            examples[row].measures[at].map_or(0.0, |value| (value - terms[at].mean) / terms[at].deviation)
        }
    });
    let mut weights = DVector::zeros(columns);
    for _ in 0..ROUNDS {
        let trusts = (&standard * &weights).map(logistic);
        let mut slope = DVector::zeros(columns);
        let mut curvature = DMatrix::zeros(columns, columns);
        for ((row, example), &trust) in standard.row_iter().zip(examples).zip(trusts.iter()) {
            let known = trust * example.labelled;
            let sum = known + (1.0 - trust) * example.unknowing;
            let responsible = if sum > 0.0 { known / sum } else { trust };
            slope += row.transpose() * (example.weight * (responsible - trust));
            curvature += row.transpose() * row * (example.weight * trust * (1.0 - trust));
        }
        for at in 1..columns {
            slope[at] -= RIDGE * weights[at];
            curvature[(at, at)] += RIDGE;
        }
        // Without examples nothing is known of the bias either.
        curvature[(0, 0)] += f64::EPSILON;
        let Some(step) = curvature.cholesky().map(|factor| factor.solve(&slope)) else { break };
        weights += step;
    }
    let terms = terms.into_iter().zip(weights.iter().skip(1));
    let terms = terms.map(|(term, &weight)| Term { weight: rounded(weight), ..term });
    Logistic {
        bias: rounded(weights[0]),
        measures: Evidence::NAMES.iter().map(|&name| name.to_owned()).zip(terms).collect(),
    }
}

/// A measure's mean and deviation over the examples that have it.
fn term(examples: &[Example], at: usize) -> Term {
    let values = || examples.iter().filter_map(|e| Some((e.measures[at]?, e.weight)));
    let sum: f64 = values().map(|(_, weight)| weight).sum::<f64>().max(f64::MIN_POSITIVE);
    let mean = values().map(|(value, weight)| weight * value).sum::<f64>() / sum;
    let variance = values().map(|(value, weight)| weight * (value - mean).powi(2)).sum::<f64>() / sum;
    Term { mean: rounded(mean), deviation: rounded(variance.sqrt()).max(1e-4), weight: 0.0 }
}

/// To four decimals: more are noise, and a file that a person reads.
fn rounded(value: f64) -> f64 {
    // Adding 0 makes 0 of -0.
    (value * 1e4).round() / 1e4 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_recognise::segment::Quality;

    #[test]
    fn what_foretells_right_answers_is_found() {
        // Neighbours are right where the first measure is low, and wrong where it is high.
        let example = |at: usize| {
            let is_low = at.is_multiple_of(2);
            let measures = std::array::from_fn(|n| match n {
                0 => Some(if is_low { 0.1 } else { 0.6 }),
                _ => Some((at * (n + 3) % 17) as f64 / 17.0),
            });
            Example { measures, labelled: if is_low { 0.9 } else { 0.02 }, unknowing: 1.0 / 6.0, weight: 1.0 }
        };
        let model = fit(&(0..400).map(example).collect::<Vec<_>>());
        assert!(model.measures["skin_around"].weight < -1.0, "{model:?}");
        assert!(model.measures["thickness"].weight.abs() < 0.3, "{model:?}");
        // What speaks against a hand is not taken for what speaks for it.
        let odd = |at: usize| {
            let mut odd = example(at);
            odd.measures[0] = odd.measures[0].map(|low| 0.7 - low);
            odd
        };
        let other = fit(&(0..400).map(odd).collect::<Vec<_>>());
        assert_eq!(other.measures["skin_around"].weight, 0.0, "{other:?}");
        let evidence = |skin_around: f64| Evidence {
            quality: Some(Quality { on_border: 0.2, skin_around, raggedness: 1.6, thickness: 0.5 }),
            share: 0.1,
            nearest: Some(0.5),
            spread_deg: 0.0,
            other_hand: None,
            scene: None,
        };
        let [sure, unsure] = [0.01, 0.36].map(|skin| model.value(&evidence(skin)));
        assert!(sure > 0.8 && unsure < 0.2, "{sure} {unsure}");
    }
}
