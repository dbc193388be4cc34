//! Which labelled pictures: the options that all subcommands over a table of labels share.

mod repeated;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use rayon::prelude::*;

use crate::evaluate::labels::{self, Kind, Label, LabelFault, OTHER, Part, RowError};
use crate::evaluate::{Outcome, folder_of, score};
use grasp_program::Global;
use grasp_recognise::Recogniser;
use grasp_terminal::text::{counted, shown};
use repeated::Repeated;

/// A table and the rows of it that are meant.
#[derive(Debug, clap::Args)]
pub(super) struct Selection {
    /// The table of labelled pictures.
    #[arg(value_name = "LABELS.csv")]
    labels: PathBuf,
    /// Take only rows whose column has this value; several must all hold.
    #[arg(long = "where", value_name = "COLUMN=VALUE", value_parser = parse_condition)]
    conditions: Vec<(String, String)>,
    /// Take all pictures, the seven tenths to choose parameters by, or the rest (split by a hash of
    /// the file's name).
    #[arg(long, value_enum, default_value_t = Part::All)]
    part: Part,
}

/// The rows that were selected.
#[derive(Debug)]
pub(super) struct Selected {
    /// Those that can be used; at least one.
    pub(super) labels: Vec<Label>,
    /// Those that cannot.
    pub(super) broken: Vec<RowError>,
    /// The folder that the labels' paths are relative to.
    pub(super) folder: PathBuf,
}

impl Selection {
    /// All rows of a table.
    pub(super) fn all(labels: &Path) -> Self {
        Self { labels: labels.to_owned(), conditions: Vec::new(), part: Part::All }
    }

    /// All rows of several tables, as [`Self::read`] reads them.
    pub(super) fn all_of(tables: &[PathBuf], classes: &[String]) -> anyhow::Result<Vec<Selected>> {
        tables.iter().map(|table| Self::all(table).read(classes)).collect()
    }

    /// Whether not all pictures are meant, but a part of them.
    pub(super) fn is_of_a_part(&self) -> bool {
        self.part != Part::All
    }

    /// The table's path.
    pub(super) fn path(&self) -> &Path {
        &self.labels
    }

    /// Reads the rows that are labelled with one of `classes`, or with none of them ([`OTHER`]).
    pub(super) fn read(&self, classes: &[String]) -> anyhow::Result<Selected> {
        let mut broken = Vec::new();
        let mut selected = Vec::new();
        let rows = labels::read(&self.labels)?;
        self.check_conditions(&rows)?;
        for row in rows {
            match row {
                Ok(label) if !label.is_selected(self.part, &self.conditions) => {}
                Ok(label) if label.grasp == OTHER || classes.contains(&label.grasp) => selected.push(label),
                Ok(label) => broken.push(RowError {
                    line: label.line,
                    fault: LabelFault::Grasp { grasp: label.grasp, classes: classes.join(", ") },
                }),
                Err(error) => broken.push(error),
            }
        }
        let (selected, contradicting) = without_contradictions(&self.labels, selected);
        broken.extend(contradicting);
        broken.sort_by_key(|error| error.line);
        if selected.is_empty() {
            let name = self.labels.display();
            match broken.first() {
                Some(error) => bail!("no row of {name} can be used; line {}: {}", error.line, error.fault),
                None if self.conditions.is_empty() && self.part == Part::default() => {
                    bail!("{name} has no rows: it labels no picture")
                }
                None => {
                    bail!("no row of {name} meets all of --where and --part together: leave one of them out")
                }
            }
        }
        let folder = folder_of(&self.labels, &selected);
        Ok(Selected { labels: selected, broken, folder })
    }

    /// Rejects a column that the table does not have, or a value that no row has in it: a slip of
    /// the keyboard must not pass for a table without such pictures.
    fn check_conditions(&self, rows: &[Result<Label, RowError>]) -> anyhow::Result<()> {
        let labels = || rows.iter().flatten();
        // A table without a sound row is reported as such.
        let Some(columns) = labels().next().map(|label| &label.columns) else { return Ok(()) };
        let name = self.labels.display();
        for (column, value) in &self.conditions {
            if !columns.contains_key(column) {
                let known = columns.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                bail!("--where {column}={value}: {name} has no column `{column}`; its columns are {known}");
            }
            let values: BTreeSet<&str> =
                labels().filter_map(|label| label.columns.get(column)).map(String::as_str).collect();
            if !values.contains(value.as_str()) {
                bail!(
                    "--where {column}={value}: no row of {name} has this value; `{column}` is {}",
                    listed(&values)
                );
            }
        }
        Ok(())
    }
}

impl Selected {
    /// The pictures and masks that the rows name.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let named = self.labels.iter().flat_map(|label| std::iter::once(&label.file).chain(&label.mask));
        named.map(|file| self.folder.join(file)).collect()
    }

    /// Whether any camera picture has a labelled mask.
    pub(super) fn has_camera_masks(&self) -> bool {
        self.labels.iter().any(|label| label.kind == Kind::Camera && label.mask.is_some())
    }

    /// All rows of a table of pictures that show none of the classes.
    pub(super) fn others(path: &Path) -> anyhow::Result<Self> {
        let (rows, broken): (Vec<_>, Vec<_>) = labels::read(path)?.into_iter().partition(Result::is_ok);
        // Whatever they are labelled.
        let other =
            |label| Label { grasp: OTHER.to_owned(), stage: String::new(), orientation: None, ..label };
        let labels = rows.into_iter().filter_map(Result::ok).map(other).collect();
        let (labels, _) = without_contradictions(path, labels);
        if labels.is_empty() {
            bail!("no row of {} can be used", path.display());
        }
        let folder = folder_of(path, &labels);
        Ok(Self { labels, broken: broken.into_iter().filter_map(Result::err).collect(), folder })
    }

    /// Recognises every picture, in parallel; the outcomes are in the table's order.
    ///
    /// # Errors
    /// Where the index was overwritten meanwhile.
    pub(super) fn score(
        &self,
        recogniser: &Recogniser<'_>,
        labelled_masks: bool,
        global: &Global,
    ) -> anyhow::Result<Vec<Outcome>> {
        let bar = global.progress().bar(self.labels.len() as u64, "recognising", "pictures");
        let outcomes = self
            .labels
            .par_iter()
            .map(|label| {
                let outcome = score(recogniser, &self.folder, label.clone(), labelled_masks);
                bar.inc(1);
                outcome
            })
            .collect();
        drop(bar);
        recogniser.index().check_unchanged().context("cannot use the index")?;
        Ok(outcomes)
    }
}

/// The rows of a table that contradict none before them, and those that do. Warns where a row
/// labels a hand again.
fn without_contradictions(table: &Path, labels: Vec<Label>) -> (Vec<Label>, Vec<RowError>) {
    let (sound, contradicting, repeated) = repeated::check(labels);
    if let Some(Repeated { line, of, count }) = repeated {
        tracing::warn!(
            subject = shown(table),
            "{} a hand that a row before does, first line {line} that of line {of}: each counts as a picture \
             of its own",
            counted(count, ["row labels", "rows label"])
        );
    }
    (sound, contradicting)
}

/// A table as files that were fitted to it name it: with the folder that it lies in, without those
/// above, which are only here.
pub(super) fn without_folders(table: &Path) -> String {
    let parts: Vec<_> = table.components().rev().take(2).collect();
    parts.into_iter().rev().collect::<PathBuf>().display().to_string()
}

/// The first values of a column, and how many more there are.
fn listed(values: &BTreeSet<&str>) -> String {
    const SHOWN: usize = 20;
    let shown: Vec<&str> =
        values.iter().take(SHOWN).map(|value| if value.is_empty() { "empty" } else { value }).collect();
    match (shown.as_slice(), values.len().saturating_sub(SHOWN)) {
        ([only], _) => format!("{only} in all rows"),
        ([first @ .., last], 0) => format!("{} or {last}", first.join(", ")),
        (_, more) => format!("{} or one of {more} more values", shown.join(", ")),
    }
}

fn parse_condition(text: &str) -> Result<(String, String), String> {
    let (column, value) = text.split_once('=').ok_or("COLUMN=VALUE is needed, for example stage=grasp")?;
    Ok((column.to_owned(), value.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_are_labelled_does_not_count_nor_contradict() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("others.csv");
        let rows = "a.jpg,camera,pinch,reach\na.jpg,camera,palmar,grasp\n,camera,pinch,grasp\n";
        std::fs::write(&path, format!("file,kind,grasp,stage\n{rows}")).unwrap();
        let others = Selected::others(&path).unwrap();
        assert_eq!(others.labels.iter().map(|label| label.line).collect::<Vec<_>>(), [2, 3]);
        assert!(others.labels.iter().all(|label| label.grasp == OTHER && label.stage.is_empty()));
        assert_eq!(others.broken.iter().map(|row| row.line).collect::<Vec<_>>(), [4]);
    }
}
