//! Which class was taken for which.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use grasp_answer::record::UNKNOWN;

/// A confusion matrix: counts of each labelled class (rows) by each answered class (columns).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Confusion {
    /// The classes, in the order of rows and columns; one more column counts pictures without an
    /// answer.
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

    /// Counts an answer; `None` where there was none. Labels that are no class of the index are
    /// left out.
    pub fn add(&mut self, labelled: &str, answered: Option<&str>) {
        let position = |name: &str| self.classes.iter().position(|class| class == name);
        let column = answered.and_then(position).unwrap_or(self.classes.len());
        if let Some(count) = position(labelled).and_then(|row| self.counts.get_mut(row)?.get_mut(column)) {
            *count += 1;
        }
    }

    /// The share of the matrix's pictures whose class was answered rightly, `None` where it is
    /// empty.
    pub fn accuracy(&self) -> Option<f64> {
        let share = self.share();
        (share.n > 0).then(|| share.top1())
    }

    /// All of the matrix's pictures, and those whose class was answered rightly.
    pub fn share(&self) -> Share {
        let right = self.counts.iter().enumerate().filter_map(|(n, row)| row.get(n)).sum();
        Share { n: self.counts.iter().flatten().sum(), right }
    }

    /// Appends the matrix as lines of text.
    ///
    /// # Errors
    /// None: writing to a String cannot fail.
    pub fn write_text(&self, text: &mut String) -> std::fmt::Result {
        // Names are too long for columns: a letter stands for each.
        let letters: Vec<char> = ('a'..='z').cycle().take(self.classes.len()).collect();
        write!(text, "  {:<18}", "")?;
        for letter in &letters {
            write!(text, " {letter:>5}")?;
        }
        writeln!(text, "  {UNKNOWN}")?;
        for ((letter, class), row) in letters.iter().zip(&self.classes).zip(&self.counts) {
            write!(text, "  {letter} {class:<16}")?;
            for count in row {
                write!(text, " {count:>5}")?;
            }
            writeln!(text)?;
        }
        Ok(())
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

    /// Between which shares the true one lies, 0..=1, with 95 % confidence (Wilson's interval,
    /// which holds for few pictures too); all that is possible where there are no pictures.
    pub fn interval(&self) -> [f64; 2] {
        const Z: f64 = 1.959_964;
        if self.n == 0 {
            return [0.0, 1.0];
        }
        let (n, share) = (self.n as f64, self.top1());
        let centre = share + Z * Z / (2.0 * n);
        let reach = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
        let [low, high] = [centre - reach, centre + reach].map(|bound| bound / (1.0 + Z * Z / n));
        [low.max(0.0), high.min(1.0)]
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

    #[test]
    fn few_pictures_say_little() {
        // As tabulated for 9 of 12 and 0 of 10.
        let interval = |n, right| Share { n, right }.interval().map(|bound| (bound * 1e3).round() / 1e3);
        assert_eq!(interval(12, 9), [0.468, 0.911]);
        assert_eq!(interval(10, 0), [0.0, 0.278]);
        assert_eq!(interval(0, 0), [0.0, 1.0]);
    }
}
