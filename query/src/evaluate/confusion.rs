//! Which class was taken for which.

use std::collections::BTreeMap;

use serde::Serialize;

/// What the program said where it gave no class.
pub const UNKNOWN: &str = "unknown";

/// A confusion matrix: counts of each labelled class (rows) by each answered class (columns).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Confusion {
    /// The classes, in the order of rows and columns; one more column counts pictures without an answer.
    pub classes: Vec<String>,
    /// `counts[labelled][answered]`.
    pub counts: Vec<Vec<usize>>,
}

impl Confusion {
    /// An empty matrix over `classes`.
    pub fn new(classes: Vec<String>) -> Self {
        let counts = vec![vec![0; classes.len() + 1]; classes.len()];
        Self { classes, counts }
    }

    /// Counts an answer; `None` where there was none. Labels that are no class of the index are left out.
    pub fn add(&mut self, labelled: &str, answered: Option<&str>) {
        let position = |name: &str| self.classes.iter().position(|class| class == name);
        let column = answered.and_then(position).unwrap_or(self.classes.len());
        if let Some(count) = position(labelled).and_then(|row| self.counts.get_mut(row)?.get_mut(column)) {
            *count += 1;
        }
    }

    /// The share of the matrix's pictures whose class was answered rightly, `None` where it is empty.
    pub fn accuracy(&self) -> Option<f64> {
        let right: usize = self.counts.iter().enumerate().filter_map(|(n, row)| row.get(n)).sum();
        let all: usize = self.counts.iter().flatten().sum();
        (all > 0).then(|| right as f64 / all as f64)
    }

    /// The share of rightly answered pictures of each class that has any.
    pub fn per_class(&self) -> BTreeMap<String, Share> {
        let rows = self.classes.iter().zip(&self.counts).enumerate();
        rows.filter_map(|(n, (class, row))| {
            let share = Share { n: row.iter().sum(), right: row.get(n).copied().unwrap_or(0) };
            (share.n > 0).then(|| (class.clone(), share))
        })
        .collect()
    }
}

/// How many of a group of pictures were classed rightly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Pictures.
    pub n: usize,
    /// Those classed rightly.
    pub right: usize,
}

impl Share {
    /// The share, 0..=1; 0 where there are no pictures.
    pub fn top1(&self) -> f64 {
        if self.n == 0 { 0.0 } else { self.right as f64 / self.n as f64 }
    }
}

impl Serialize for Share {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct as _;
        let mut fields = serializer.serialize_struct("Share", 3)?;
        fields.serialize_field("n", &self.n)?;
        fields.serialize_field("right", &self.right)?;
        fields.serialize_field("top1", &self.top1())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_counts_by_label_and_answer() {
        let mut confusion = Confusion::new(vec!["pinch".into(), "disc".into()]);
        confusion.add("pinch", Some("pinch"));
        confusion.add("pinch", Some("disc"));
        confusion.add("disc", None);
        confusion.add("other", Some("disc"));
        assert_eq!(confusion.counts, [[1, 1, 0], [0, 0, 1]]);
        assert_eq!(confusion.accuracy(), Some(1.0 / 3.0));
        assert_eq!(confusion.per_class()["pinch"], Share { n: 2, right: 1 });
        assert_eq!(Confusion::new(Vec::new()).accuracy(), None);
    }
}
