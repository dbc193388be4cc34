//! Reading and writing `manifest.csv`. The columns are documented in [`super`].

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use nalgebra::{Quaternion, UnitQuaternion};

use crate::grasp::{GraspSet, Stage};
use crate::view::View;

/// Name of the manifest in a render set's folder.
pub const MANIFEST: &str = "manifest.csv";

/// All columns in the order in which they are written.
const COLUMNS: [&str; 14] = [
    "file",
    "hand_shape",
    "grasp",
    "cutkosky",
    "stage",
    "azimuth",
    "elevation",
    "roll",
    "qx",
    "qy",
    "qz",
    "qw",
    "object",
    "seed",
];

/// Columns that no manifest may lack.
const NEEDED: [&str; 6] = ["file", "grasp", "qx", "qy", "qz", "qw"];

/// How far a quaternion's length may be from 1: five decimals are enough.
const UNIT_TOLERANCE: f64 = 1e-3;

/// One render of a set.
#[derive(Debug, Clone, PartialEq)]
pub struct ManifestRow {
    /// The picture, relative to the manifest's folder.
    pub file: String,
    /// Whose hand.
    pub hand_shape: String,
    /// The grasp's name.
    pub grasp: String,
    /// The grasp's number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// How far it is closed.
    pub stage: Stage,
    /// From where, in degrees.
    pub view: View,
    /// The rotation from the hand's frame into the camera's.
    pub camera_from_hand: UnitQuaternion<f64>,
    /// What the hand holds.
    pub object: String,
    /// Seed of the variations.
    pub seed: u64,
}

/// A render set's table.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// The folder that the files are relative to.
    pub folder: PathBuf,
    /// The renders, in the file's order.
    pub rows: Vec<ManifestRow>,
}

/// A manifest that cannot be used, and where.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// The file cannot be read.
    #[error("cannot read the manifest {path}")]
    Read {
        /// The manifest.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The header lacks a column.
    #[error("{path}: line 1: column `{column}` is missing: file, grasp, qx, qy, qz and qw are needed")]
    MissingColumn {
        /// The manifest.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// No render at all.
    #[error("{path}: the manifest lists no render")]
    Empty {
        /// The manifest.
        path: PathBuf,
    },
    /// A line is wrong.
    #[error("{path}: line {line}: {problem}")]
    Line {
        /// The manifest.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What is wrong.
        problem: Problem,
    },
}

/// What is wrong with a line of a manifest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Not CSV, or not as many fields as the header has.
    #[error("not a line of this table: {0}")]
    Csv(String),
    /// A field that should be a number.
    #[error("`{value}` in column `{column}` is not a number in the range of that column")]
    Number {
        /// The column.
        column: &'static str,
        /// What stands there.
        value: String,
    },
    /// The four numbers are no rotation.
    #[error("qx, qy, qz, qw have length {0:.4}: camera_from_hand must be a unit quaternion")]
    NotUnit(f64),
    /// The file would lie outside the manifest's folder.
    #[error("the file `{0}` leads out of the manifest's folder")]
    Escapes(String),
    /// The file is not there.
    #[error("the file `{0}` does not exist")]
    MissingFile(String),
    /// No grasp has this name.
    #[error("there is no grasp `{name}`: the grasps are {known}")]
    UnknownGrasp {
        /// What stands there.
        name: String,
        /// What could.
        known: String,
    },
    /// The grasp's number and name do not agree.
    #[error("grasp `{grasp}` is number {right}, not {wrong}")]
    Cutkosky {
        /// The grasp.
        grasp: String,
        /// Its number.
        right: u8,
        /// What stands there.
        wrong: u8,
    },
    /// No stage has this name.
    #[error(transparent)]
    Stage(#[from] crate::grasp::UnknownStage),
}

impl Manifest {
    /// Reads and checks a manifest whose classes are the built-in grasps.
    ///
    /// # Errors
    ///
    /// See [`Manifest::read_with`].
    pub fn read(path: impl AsRef<Path>) -> Result<Manifest, ManifestError> {
        Manifest::read_with(path, &GraspSet::builtin())
    }

    /// Reads and checks a manifest: `path` is the file, or the folder that holds a `manifest.csv`.
    ///
    /// # Errors
    ///
    /// With the line's number: a column that is missing, a field that is no number, a quaternion
    /// that is not of unit length, a grasp that `grasps` does not have, a file that leads out of
    /// the folder or does not exist.
    pub fn read_with(path: impl AsRef<Path>, grasps: &GraspSet) -> Result<Manifest, ManifestError> {
        let mut path = path.as_ref().to_owned();
        if path.is_dir() {
            path.push(MANIFEST);
        }
        let bytes = fs::read(&path).map_err(|source| ManifestError::Read { path: path.clone(), source })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
        let at_line = |line: u64, problem: Problem| ManifestError::Line { path: path.clone(), line, problem };
        let header = reader.headers().map_err(|e| at_line(1, Problem::Csv(e.to_string())))?.clone();
        // Excel and others put a byte order mark before the first name.
        let position = |column: &str| header.iter().position(|h| h.trim_start_matches('\u{feff}') == column);
        for column in NEEDED {
            if position(column).is_none() {
                return Err(ManifestError::MissingColumn { path, column });
            }
        }
        let columns = COLUMNS.map(|column| (column, position(column)));
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| {
                let line = e.position().map_or(0, csv::Position::line);
                at_line(line, Problem::Csv(csv_problem(&e)))
            })?;
            let line = record.position().map_or(0, csv::Position::line);
            let fields = Fields { columns: &columns, record: &record };
            let row = fields.row(grasps).map_err(|problem| at_line(line, problem))?;
            if !folder.join(&row.file).is_file() {
                return Err(at_line(line, Problem::MissingFile(row.file)));
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(ManifestError::Empty { path });
        }
        Ok(Manifest { folder, rows })
    }
}

/// The reason without the position, which the message has anyway.
fn csv_problem(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("it has {len} fields where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "it is not UTF-8 text".to_owned(),
        _ => error.to_string(),
    }
}

struct Fields<'a> {
    columns: &'a [(&'static str, Option<usize>); COLUMNS.len()],
    record: &'a csv::StringRecord,
}

impl Fields<'_> {
    /// The field's text; `None` when it is absent or empty.
    fn text(&self, column: &str) -> Option<&str> {
        let (_, position) = self.columns.iter().find(|(name, _)| *name == column)?;
        self.record.get((*position)?).filter(|text| !text.is_empty())
    }

    fn number<T: std::str::FromStr>(&self, column: &'static str) -> Result<Option<T>, Problem> {
        let parse = |text: &str| text.parse().map_err(|_| Problem::Number { column, value: text.to_owned() });
        self.text(column).map(parse).transpose()
    }

    fn angle(&self, column: &'static str) -> Result<f64, Problem> {
        let value: f64 = self.number(column)?.unwrap_or(0.0);
        if value.is_finite() { Ok(value) } else { Err(Problem::Number { column, value: value.to_string() }) }
    }

    fn row(&self, grasps: &GraspSet) -> Result<ManifestRow, Problem> {
        let file = self.text("file").unwrap_or_default().to_owned();
        let inside =
            Path::new(&file).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if file.is_empty() {
            return Err(Problem::MissingFile(file));
        }
        if !inside {
            return Err(Problem::Escapes(file));
        }
        let name = self.text("grasp").unwrap_or_default();
        let Some(grasp) = grasps.get(name) else {
            let known: Vec<&str> = grasps.iter().map(|g| g.name.as_str()).collect();
            return Err(Problem::UnknownGrasp { name: name.to_owned(), known: known.join(", ") });
        };
        if let Some(wrong) = self.number("cutkosky")?
            && wrong != grasp.cutkosky
        {
            return Err(Problem::Cutkosky { grasp: name.to_owned(), right: grasp.cutkosky, wrong });
        }
        Ok(ManifestRow {
            file,
            hand_shape: self.text("hand_shape").unwrap_or("unknown").to_owned(),
            grasp: grasp.name.clone(),
            cutkosky: grasp.cutkosky,
            stage: self.text("stage").unwrap_or("grasp").parse()?,
            view: View {
                azimuth_deg: self.angle("azimuth")?,
                elevation_deg: self.angle("elevation")?,
                roll_deg: self.angle("roll")?,
            },
            camera_from_hand: self.rotation()?,
            object: self.text("object").unwrap_or_default().to_owned(),
            seed: self.number("seed")?.unwrap_or(0),
        })
    }

    fn rotation(&self) -> Result<UnitQuaternion<f64>, Problem> {
        let mut parts = [0.0f64; 4];
        for (part, column) in parts.iter_mut().zip(["qx", "qy", "qz", "qw"]) {
            let missing = || Problem::Number { column, value: String::new() };
            *part = self.number(column)?.ok_or_else(missing)?;
        }
        let [x, y, z, w] = parts;
        let q = Quaternion::new(w, x, y, z);
        let length = q.norm();
        if (length - 1.0).abs() <= UNIT_TOLERANCE {
            Ok(UnitQuaternion::new_normalize(q))
        } else {
            Err(Problem::NotUnit(length))
        }
    }
}

/// The rows as CSV text; floats are written so that they read back exactly.
pub(super) fn to_csv(rows: impl Iterator<Item = ManifestRow>) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS)?;
    for row in rows {
        let q = row.camera_from_hand.coords;
        writer.write_record([
            row.file,
            row.hand_shape,
            row.grasp,
            row.cutkosky.to_string(),
            row.stage.to_string(),
            row.view.azimuth_deg.to_string(),
            row.view.elevation_deg.to_string(),
            row.view.roll_deg.to_string(),
            q.x.to_string(),
            q.y.to_string(),
            q.z.to_string(),
            q.w.to_string(),
            row.object,
            row.seed.to_string(),
        ])?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}
