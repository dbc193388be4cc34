//! Rows of a table that label the same hand of the same picture.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

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

/// Takes rows out that contradict one before them, as errors in the table's order, and reports
/// those that repeat one. A row is of the same hand as another if picture, mask, kind and hand are
/// the same; what one of them leaves open contradicts nothing.
pub(super) fn check(labels: Vec<Label>) -> (Vec<Label>, Vec<RowError>, Option<Repeated>) {
    let (mut sound, mut broken, mut repeated) = (Vec::<Label>::new(), Vec::new(), None::<Repeated>);
    let mut places: HashMap<_, usize> = HashMap::new();
    for label in labels {
        let first = match places.entry((label.file.clone(), label.mask.clone(), label.kind, label.hand)) {
            Entry::Occupied(place) => sound.get(*place.get()),
            Entry::Vacant(place) => {
                place.insert(sound.len());
                None
            }
        };
        if let Some(first) = first {
            if let Some(column) = contradiction(first, &label) {
                let fault = LabelFault::Contradicts { column, line: first.line };
                broken.push(RowError { line: label.line, fault });
                continue;
            }
            let of = first.line;
            repeated.get_or_insert(Repeated { line: label.line, of, count: 0 }).count += 1;
        }
        sound.push(label);
    }
    (sound, broken, repeated)
}

/// In what two labels of one hand differ.
fn contradiction(one: &Label, other: &Label) -> Option<&'static str> {
    let differ = |a: &str, b: &str| a != b && !a.is_empty() && !b.is_empty();
    let angle = one.orientation.zip(other.orientation).map(|(a, b)| a.angle_to(&b).to_degrees());
    if differ(&one.grasp, &other.grasp) {
        Some("grasp")
    } else if differ(&one.stage, &other.stage) {
        Some("stage")
    } else {
        angle.is_some_and(|angle| angle > ROUNDING_DEG).then_some("orientation")
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
