//! Which pictures tell most: the surest answers that are right, the surest that are wrong, and
//! those that are doubtful by their own words.

use serde::Serialize;

use crate::evaluate::Outcome;
use grasp_answer::record::UNKNOWN;

/// An answer that states less is doubtful: some other class is right more often than not.
const DOUBTFUL: f64 = 0.5;

/// The pictures that are shown: each at most once.
#[derive(Clone, Debug, Serialize)]
pub struct Shelves {
    /// Answers that are right and state at least 0.5, the most probable first.
    pub right: Shelf,
    /// Answers that are wrong and state at least 0.5, the most probable first.
    pub wrong: Shelf,
    /// Pictures without a hand or of an unknown class, and answers that state less, the least
    /// probable first.
    pub doubtful: Shelf,
}

/// Pictures of one sort.
#[derive(Clone, Debug, Serialize)]
pub struct Shelf {
    /// How many there are.
    pub n: usize,
    /// Those that are shown.
    pub pictures: Vec<Shown>,
}

/// A picture with its answer and the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shown {
    /// The line of the table.
    pub line: u64,
    /// The picture as the table names it.
    pub file: String,
    /// The class that was answered, or `unknown`; null where no hand was found.
    pub grasp: Option<String>,
    /// The most probable class, known or not; null where no hand was found.
    pub most_probable: Option<String>,
    /// Its probability.
    pub probability: Option<f64>,
    /// The labelled class.
    pub labelled: String,
    /// How far the answered rotation is from the labelled one, in degrees.
    pub orientation_error_deg: Option<f64>,
}

/// Whether a picture could be used at all, whatever was found in it.
pub(super) fn is_usable(outcome: &Outcome) -> bool {
    outcome.result.as_ref().map_or_else(|miss| miss.is_rejection, |_| true)
}

impl Shelves {
    /// Sorts outcomes, and shows at most `show` of each sort.
    pub(super) fn new(outcomes: &[Outcome], show: usize) -> Self {
        let usable: Vec<(Shown, bool)> = outcomes
            .iter()
            .filter(|outcome| is_usable(outcome))
            .map(|outcome| (Shown::new(outcome), outcome.is_right()))
            .collect();
        let (doubtful, sure): (Vec<_>, Vec<_>) =
            usable.into_iter().partition(|(shown, _)| shown.is_doubtful());
        let (right, wrong): (Vec<_>, Vec<_>) = sure.into_iter().partition(|(_, is_right)| *is_right);
        let [right, wrong, doubtful] =
            [right, wrong, doubtful].map(|sort| sort.into_iter().map(|(shown, _)| shown).collect());
        let surest_first = |shown: &Shown| -shown.probability.unwrap_or_default();
        Self {
            right: Shelf::new(right, show, surest_first),
            wrong: Shelf::new(wrong, show, surest_first),
            doubtful: Shelf::new(doubtful, show, |shown| shown.probability.unwrap_or_default()),
        }
    }
}

impl Shelf {
    fn new(mut pictures: Vec<Shown>, show: usize, key: impl Fn(&Shown) -> f64) -> Self {
        // Stable: what is as probable stays in the table's order.
        pictures.sort_by(|one, other| key(one).total_cmp(&key(other)));
        let n = pictures.len();
        pictures.truncate(show);
        Self { n, pictures }
    }
}

impl Shown {
    fn new(outcome: &Outcome) -> Self {
        let guess = outcome.result.as_ref().ok();
        Self {
            line: outcome.label.line,
            file: outcome.label.file.clone(),
            grasp: guess.map(|guess| guess.grasp.clone()),
            most_probable: guess.and_then(|guess| Some(guess.classes.first()?.0.clone())),
            probability: guess.map(|guess| guess.probability),
            labelled: outcome.label.grasp.clone(),
            orientation_error_deg: outcome.orientation_error_deg(),
        }
    }

    fn is_doubtful(&self) -> bool {
        let is_unknown = self.grasp.as_ref().is_none_or(|grasp| grasp == UNKNOWN);
        is_unknown || self.probability.is_none_or(|probability| probability < DOUBTFUL)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(line: u64, grasp: Option<&str>, probability: Option<f64>) -> Shown {
        Shown {
            line,
            file: format!("{line}.png"),
            grasp: grasp.map(str::to_owned),
            most_probable: grasp.map(str::to_owned),
            probability,
            labelled: "pinch".into(),
            orientation_error_deg: None,
        }
    }

    #[test]
    fn an_answer_that_is_hardly_one_is_doubtful() {
        assert!(shown(2, None, None).is_doubtful());
        assert!(shown(2, Some(UNKNOWN), Some(0.9)).is_doubtful());
        assert!(shown(2, Some("pinch"), Some(0.49)).is_doubtful());
        assert!(!shown(2, Some("pinch"), Some(0.5)).is_doubtful());
    }

    #[test]
    fn the_first_are_shown_and_all_are_counted() {
        let pictures = vec![shown(2, None, None), shown(3, Some("disc"), Some(0.4)), shown(4, None, None)];
        let shelf = Shelf::new(pictures, 2, |shown| shown.probability.unwrap_or_default());
        let lines: Vec<u64> = shelf.pictures.iter().map(|shown| shown.line).collect();
        assert_eq!((shelf.n, lines), (3, vec![2, 4]));
    }
}
