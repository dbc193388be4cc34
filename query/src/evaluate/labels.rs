//! The table of labelled pictures: which picture shows what.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use grasp_index::NETWORK_STAGES;
use grasp_labels::{REMARK, Row, RowFault, Table};
use nalgebra::UnitQuaternion;
use serde::Serialize;
use xxhash_rust::xxh3::xxh3_64;

use grasp_recognise::Side;

/// The class name of a hand in none of the six grasps.
pub const OTHER: &str = "other";

/// Whether a picture is segmented.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A hand on black.
    Segmented,
    /// A whole picture.
    Camera,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Segmented => "segmented",
            Self::Camera => "camera",
        })
    }
}

/// The two parts that pictures are split into once and for all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Every picture.
    #[default]
    All,
    /// Seven tenths, to choose parameters by.
    Choose,
    /// Three tenths, to be scored only at the end.
    Final,
}

/// One labelled picture.
#[derive(Clone, Debug)]
pub struct Label {
    /// The line of the table, counted from 1 with its header.
    pub line: u64,
    /// The picture as the table names it.
    pub file: String,
    /// The mask as the table names it.
    pub mask: Option<String>,
    /// Whether the picture is segmented.
    pub kind: Kind,
    /// The class name, or [`OTHER`].
    pub grasp: String,
    /// How far the grasp is closed, one of [`NETWORK_STAGES`]; may be empty.
    pub stage: String,
    /// Which hand, where it is known.
    pub hand: Option<Side>,
    /// `camera_from_hand`, where it is known.
    pub orientation: Option<UnitQuaternion<f64>>,
    /// Every column by name, for `--where`.
    pub columns: BTreeMap<String, String>,
}

/// A table of labels that cannot be used at all.
#[derive(Debug, thiserror::Error)]
pub enum LabelsError {
    /// The file cannot be read.
    #[error("cannot read the labels {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Its first line is no header.
    #[error("cannot read the labels {}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// Why.
        source: RowFault,
    },
    /// A column that is needed is missing.
    #[error("{}: the labels have no column `{column}`; their header is {}", path.display(), described(found))]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The missing column.
        column: &'static str,
        /// The columns that are there.
        found: String,
    },
}

/// A header in a sentence that complains of it.
fn described(header: &str) -> String {
    match header {
        "" => "empty".to_owned(),
        other if !other.contains(", ") && other.contains([';', '\t']) => {
            format!("{other}, where columns must be separated by commas")
        }
        other => other.to_owned(),
    }
}

/// A row that cannot be used; the others can.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}: {fault}")]
pub struct RowError {
    /// The line of the table.
    pub line: u64,
    /// What is wrong with it; part of the message, and so no source beside it.
    pub fault: LabelFault,
}

/// What is wrong with a row.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LabelFault {
    /// Not a line of the table, or a field of it is not what its column holds.
    #[error(transparent)]
    Row(#[from] RowFault),
    /// A kind of picture that there is not.
    #[error("kind is `{0}`, it must be segmented or camera")]
    Kind(String),
    /// No stage of a grasp.
    #[error("stage is `{0}`, it must be {stages} or empty", stages = NETWORK_STAGES.join(", "))]
    Stage(String),
    /// Neither hand.
    #[error("hand is `{0}`, it must be left, right or empty")]
    Hand(String),
    /// A value that is needed.
    #[error("no {0}")]
    Missing(&'static str),
    /// A class that the index does not have.
    #[error("`{grasp}` is not one of the classes {classes}; `{OTHER}` stands for a hand in none of them")]
    Grasp {
        /// What stands there.
        grasp: String,
        /// The index's classes.
        classes: String,
    },
    /// The same hand of the same picture is labelled otherwise before.
    #[error("another {column} than line {line} has for the same hand: keep the one that is right")]
    Contradicts {
        /// What differs.
        column: &'static str,
        /// The line before.
        line: u64,
    },
}

/// Reads a table of labels: columns `file, kind, grasp` are needed; `mask, stage, hand, qx, qy, qz,
/// qw` are used where they are there, and all others can be filtered by. A broken row becomes an
/// error in its place.
///
/// # Errors
/// Where the file cannot be read or a needed column is missing.
pub fn read(path: &Path) -> Result<Vec<Result<Label, RowError>>, LabelsError> {
    let path = || path.to_owned();
    let file = File::open(path()).map_err(|source| LabelsError::Read { path: path(), source })?;
    let table = Table::new(file, Some(REMARK));
    let mut table = table.map_err(|source| LabelsError::Header { path: path(), source })?;
    if let Some(column) = ["file", "kind", "grasp"].into_iter().find(|column| !table.has(column)) {
        let found = table.columns().collect::<Vec<_>>().join(", ");
        return Err(LabelsError::MissingColumn { path: path(), column, found });
    }
    let mut rows = Vec::new();
    loop {
        let row = match table.advance() {
            Ok(false) => return Ok(rows),
            Ok(true) => table.row().map_err(LabelFault::from),
            Err(fault) => Err(fault.into()),
        };
        let line = table.line();
        let columns =
            || table.fields().map(|(column, value)| (column.to_owned(), value.to_owned())).collect();
        let label = row.and_then(|row| label(line, &row, columns()));
        rows.push(label.map_err(|fault| RowError { line, fault }));
    }
}

fn label(line: u64, row: &Row<'_>, columns: BTreeMap<String, String>) -> Result<Label, LabelFault> {
    let needed = |name, value: Option<&str>| value.map(str::to_owned).ok_or(LabelFault::Missing(name));
    Ok(Label {
        line,
        kind: match row.kind {
            Some("segmented") => Kind::Segmented,
            Some("camera") => Kind::Camera,
            other => return Err(LabelFault::Kind(other.unwrap_or("nothing").to_owned())),
        },
        hand: match row.hand {
            None => None,
            Some("left") => Some(Side::Left),
            Some("right") => Some(Side::Right),
            Some(other) => return Err(LabelFault::Hand(other.to_owned())),
        },
        file: needed("file", row.file)?,
        mask: row.mask.map(str::to_owned),
        grasp: needed("grasp", row.grasp)?,
        stage: match row.stage {
            Some(stage) if !NETWORK_STAGES.contains(&stage) => {
                return Err(LabelFault::Stage(stage.to_owned()));
            }
            stage => stage.unwrap_or_default().to_owned(),
        },
        orientation: row.orientation()?,
        columns,
    })
}

impl Label {
    /// The part that the picture belongs to, by the hash of its name without folder and ending: the
    /// segmented and the camera picture of one view have the same name and fall on the same side.
    pub fn part(&self) -> Part {
        let stem = Path::new(&self.file).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
        if xxh3_64(stem.as_bytes()) % 10 < 7 { Part::Choose } else { Part::Final }
    }

    /// Whether the label is in `part` and has the value of every `(column, value)`.
    pub fn is_selected(&self, part: Part, conditions: &[(String, String)]) -> bool {
        (part == Part::All || part == self.part())
            && conditions
                .iter()
                .all(|(column, value)| self.columns.get(column).is_some_and(|found| found == value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "file,mask,kind,grasp,stage,hand,qx,qy,qz,qw,group\n";

    fn rows(text: &str) -> Vec<Result<Label, RowError>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.csv");
        std::fs::write(&path, format!("{HEADER}{text}")).unwrap();
        read(&path).unwrap()
    }

    #[test]
    fn a_row_says_all_there_is_to_say() {
        let rows = rows("a/b.jpg,m.png,segmented,pinch,reach,left,0,0,0.6,0.8,thumb\n");
        let label = rows[0].as_ref().unwrap();
        assert_eq!(
            (label.file.as_str(), label.mask.as_deref(), label.kind),
            ("a/b.jpg", Some("m.png"), Kind::Segmented)
        );
        assert_eq!(
            (label.grasp.as_str(), label.stage.as_str(), label.hand),
            ("pinch", "reach", Some(Side::Left))
        );
        assert!((label.orientation.unwrap().w - 0.8).abs() < 1e-12);
        assert!(label.is_selected(Part::All, &[("group".into(), "thumb".into())]));
        assert!(!label.is_selected(Part::All, &[("group".into(), "dorsal".into())]));
        assert!(!label.is_selected(Part::All, &[("grup".into(), "thumb".into())]));
    }

    #[test]
    fn broken_rows_are_named_and_the_others_kept() {
        let rows = rows(concat!(
            "a.png,,camera,pinch,,,,,,,\n",
            "b.png,,photo,pinch,,,,,,,\n",
            "c.png,,camera,pinch,,,1,1,1,1,\n",
            "d.png,,camera\n",
            "e.png,,camera,other,,,,,,,\n",
            "f.png,,camera,pinch,grasping,,,,,,\n",
        ));
        let wrong: Vec<(u64, String)> =
            rows.iter().filter_map(|row| row.as_ref().err()).map(|e| (e.line, e.fault.to_string())).collect();
        assert_eq!(wrong.len(), 4);
        assert_eq!(wrong[0], (3, "kind is `photo`, it must be segmented or camera".into()));
        assert!(wrong[1].1.contains("must be a unit quaternion"));
        assert_eq!(wrong[2], (5, "not a line of this table: it has 3 fields where the header has 11".into()));
        assert_eq!(wrong[3], (7, "stage is `grasping`, it must be reach, close, grasp or empty".into()));
        assert_eq!(rows.iter().filter(|row| row.is_ok()).count(), 2);
    }

    #[test]
    fn a_missing_column_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.csv");
        for (text, said) in [
            ("file,grasp\na.png,pinch\n", "no column `kind`; their header is file, grasp"),
            ("file;kind;grasp\n", "`file`; their header is file;kind;grasp, where columns must be separated"),
            ("", "`file`; their header is empty"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn both_pictures_of_a_view_are_in_the_same_part_and_seven_tenths_are_to_choose_by() {
        let text: String = (0..1000)
            .map(|n| format!("easy/v{n}.jpg,,camera,pinch,,,,,,,\nscene/v{n}.png,,camera,pinch,,,,,,,\n"))
            .collect();
        let rows: Vec<Label> = rows(&text).into_iter().map(Result::unwrap).collect();
        assert!(rows.chunks(2).all(|pair| pair[0].part() == pair[1].part()));
        let choose = rows.iter().filter(|row| row.part() == Part::Choose).count();
        assert!((1300..1500).contains(&choose), "{choose}");
    }
}
