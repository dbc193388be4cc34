//! Rows of a table that label the same hand of the same picture.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use nalgebra::UnitQuaternion;

use crate::evaluate::labels::{Label, LabelFault, RowError};

/// Quaternions of one orientation differ by no more, in degrees, however they were rounded.
const ROUNDING_DEG: f64 = 0.1;

/// Rows that say what a row before them says: each counts as a picture of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Repeated {
    /// The line of the first of them.
    pub(super) line: u64,
    /// The line of the row that it repeats.
    pub(super) of: u64,
    /// How many they are.
    pub(super) count: usize,
}

/// What the rows so far say of a hand, each with the line that said it first; empty where all leave
/// it open.
struct Hand {
    line: u64,
    grasp: Said<String>,
    stage: Said<String>,
    orientation: Said<UnitQuaternion<f64>>,
}

type Said<T> = Option<(T, u64)>;

/// Takes rows out that contradict one before them, as errors in the table's order, and reports
/// those that repeat one. A row is of the same hand as another if picture, mask, kind and hand are
/// the same; what one of them leaves open contradicts nothing.
pub(super) fn check(labels: Vec<Label>) -> (Vec<Label>, Vec<RowError>, Option<Repeated>) {
    let (mut sound, mut broken, mut repeated) = (Vec::new(), Vec::new(), None::<Repeated>);
    let mut hands: HashMap<_, Hand> = HashMap::new();
    for label in labels {
        match hands.entry((label.file.clone(), label.mask.clone(), label.kind, label.hand)) {
            Entry::Vacant(place) => {
                let unsaid = Hand { line: label.line, grasp: None, stage: None, orientation: None };
                place.insert(unsaid).add(&label);
            }
            Entry::Occupied(mut place) => {
                let hand = place.get_mut();
                if let Some((column, line)) = hand.contradiction(&label) {
                    let fault = LabelFault::Contradicts { column, line };
                    broken.push(RowError { line: label.line, fault });
                    continue;
                }
                hand.add(&label);
                repeated.get_or_insert(Repeated { line: label.line, of: hand.line, count: 0 }).count += 1;
            }
        }
        sound.push(label);
    }
    (sound, broken, repeated)
}

impl Hand {
    /// The column in which a row contradicts what is said, and the line that said it.
    fn contradiction(&self, label: &Label) -> Option<(&'static str, u64)> {
        let differs = |column, said: &Said<String>, text: &str| {
            let other = said.as_ref().filter(|(said, _)| said != text && !text.is_empty());
            other.map(|(_, line)| (column, *line))
        };
        let turned = |(said, line): &(UnitQuaternion<f64>, u64)| {
            let angle = said.angle_to(label.orientation.as_ref()?).to_degrees();
            (angle > ROUNDING_DEG).then_some(("orientation", *line))
        };
        differs("grasp", &self.grasp, &label.grasp)
            .or_else(|| differs("stage", &self.stage, &label.stage))
            .or_else(|| self.orientation.as_ref().and_then(turned))
    }

    /// Adds what a row says and no row before it.
    fn add(&mut self, label: &Label) {
        let text = |text: &str| (!text.is_empty()).then(|| (text.to_owned(), label.line));
        self.grasp = self.grasp.take().or_else(|| text(&label.grasp));
        self.stage = self.stage.take().or_else(|| text(&label.stage));
        self.orientation = self.orientation.or(label.orientation.map(|rotation| (rotation, label.line)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::labels;

    /// What is found in a table of these rows: the lines that stay, those that do not and why, and
    /// what is repeated.
    fn checked(rows: &str) -> (Vec<u64>, Vec<String>, Option<Repeated>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.csv");
        std::fs::write(&path, format!("file,mask,kind,grasp,stage,hand,qx,qy,qz,qw\n{rows}")).unwrap();
        let labels = labels::read(&path).unwrap().into_iter().map(Result::unwrap).collect();
        let (sound, broken, repeated) = check(labels);
        let broken = broken.iter().map(ToString::to_string).collect();
        (sound.iter().map(|label| label.line).collect(), broken, repeated)
    }

    #[test]
    fn rows_that_say_the_same_stay_and_are_counted() {
        // The opposite quaternion is the same orientation, and an open stage contradicts nothing.
        let rows = "\
a.jpg,m.png,camera,pinch,grasp,left,0,0,0.6,0.8
b.jpg,m.png,camera,pinch,grasp,left,0,0,0.6,0.8
a.jpg,m.png,camera,pinch,,left,0,0,-0.6,-0.8
a.jpg,m.png,camera,pinch,grasp,left,,,,
";
        let repeated = Some(Repeated { line: 4, of: 2, count: 2 });
        assert_eq!(checked(rows), (vec![2, 3, 4, 5], vec![], repeated));
    }

    #[test]
    fn what_the_first_row_leaves_open_a_later_one_says() {
        let rows = "\
a.jpg,,camera,pinch,,left,,,,
a.jpg,,camera,pinch,grasp,left,,,,
a.jpg,,camera,pinch,reach,left,0,0,0,1
a.jpg,,camera,pinch,grasp,left,0,0,0,1
a.jpg,,camera,pinch,,left,1,0,0,0
";
        let said = |line: u64, column: &str, of: u64| {
            let why = "has for the same hand: keep the one that is right";
            format!("line {line}: another {column} than line {of} {why}")
        };
        let broken = vec![said(4, "stage", 3), said(6, "orientation", 5)];
        assert_eq!(checked(rows), (vec![2, 3, 5], broken, Some(Repeated { line: 3, of: 2, count: 2 })));
    }

    #[test]
    fn other_masks_hands_and_kinds_are_other_hands() {
        let rows = "\
a.jpg,m.png,camera,pinch,grasp,left,,,,
a.jpg,n.png,camera,palmar,grasp,left,,,,
a.jpg,m.png,camera,lateral,grasp,right,,,,
a.jpg,m.png,segmented,palmar,grasp,left,,,,
";
        assert_eq!(checked(rows), (vec![2, 3, 4, 5], vec![], None));
    }

    #[test]
    fn rows_that_contradict_one_before_are_errors() {
        let rows = "\
a.jpg,,camera,pinch,grasp,left,0,0,0.6,0.8
a.jpg,,camera,palmar,grasp,left,0,0,0.6,0.8
a.jpg,,camera,pinch,reach,left,0,0,0.6,0.8
a.jpg,,camera,pinch,grasp,left,0,0,0,1
";
        let said = |line: u64, column: &str| {
            format!(
                "line {line}: another {column} than line 2 has for the same hand: keep the one that is right"
            )
        };
        let broken = vec![said(3, "grasp"), said(4, "stage"), said(5, "orientation")];
        assert_eq!(checked(rows), (vec![2], broken, None));
    }
}
