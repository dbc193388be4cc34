//! Reading and writing `manifest.csv`. The columns are documented in [`super`].

use std::collections::HashSet;
use std::io;
use std::path::{Component, Path, PathBuf};

use grasp_labels::{Row, RowFault, Table};
use nalgebra::UnitQuaternion;

use crate::grasp::{GraspSet, Stage};
use crate::view::View;

/// Name of the manifest in a render set's folder.
pub const MANIFEST: &str = "manifest.csv";

/// Columns that no manifest may lack.
const NEEDED: [&str; 6] = ["file", "grasp", "qx", "qy", "qz", "qw"];

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
    /// Not a line of the table, or a field of it is not what its column holds.
    #[error(transparent)]
    Row(#[from] RowFault),
    /// Another line lists the same file.
    #[error("the file `{0}` is listed twice")]
    Twice(String),
    /// The picture shows a left hand.
    #[error("hand is `{0}`: a render set shows right hands; flip pictures of left ones, and their rotations")]
    Hand(String),
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
    /// Checks what the manifest at `path` says, of which these are the `bytes`.
    ///
    /// # Errors
    ///
    /// With the line's number: a column that is missing, a field that is no number, a quaternion
    /// that is not of unit length, a grasp that `grasps` does not have, a file that leads out of
    /// the folder, does not exist or is listed twice.
    pub fn parse(bytes: &[u8], path: PathBuf, grasps: &GraspSet) -> Result<Manifest, ManifestError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let at_line = |line: u64, problem: Problem| ManifestError::Line { path: path.clone(), line, problem };
        let mut table = Table::new(bytes, None).map_err(|fault| at_line(1, fault.into()))?;
        if let Some(column) = NEEDED.into_iter().find(|column| !table.has(column)) {
            return Err(ManifestError::MissingColumn { path, column });
        }
        let (mut rows, mut files) = (Vec::new(), HashSet::new());
        while table.advance().map_err(|fault| at_line(table.line(), fault.into()))? {
            let row = table.row().map_err(Problem::from);
            let render = row.and_then(|row| render(&row, &folder, grasps)).and_then(|render| {
                match files.insert(plain(&render.file)) {
                    true => Ok(render),
                    false => Err(Problem::Twice(render.file)),
                }
            });
            rows.push(render.map_err(|problem| at_line(table.line(), problem))?);
        }
        if rows.is_empty() {
            return Err(ManifestError::Empty { path });
        }
        Ok(Manifest { folder, rows })
    }
}

/// A path without `.` and empty parts: the same for the same file.
fn plain(file: &str) -> PathBuf {
    Path::new(file).components().filter(|part| matches!(part, Component::Normal(_))).collect()
}

/// The render of a line, whose file lies in `folder`.
fn render(row: &Row<'_>, folder: &Path, grasps: &GraspSet) -> Result<ManifestRow, Problem> {
    let file = row.file.unwrap_or_default();
    if !Path::new(file).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        return Err(Problem::Escapes(file.to_owned()));
    }
    if let Some(hand) = row.hand.filter(|hand| !hand.is_empty() && *hand != "right") {
        return Err(Problem::Hand(hand.to_owned()));
    }
    let name = row.grasp.unwrap_or_default();
    let Some(grasp) = grasps.get(name) else {
        let known: Vec<&str> = grasps.iter().map(|g| g.name.as_str()).collect();
        return Err(Problem::UnknownGrasp { name: name.to_owned(), known: known.join(", ") });
    };
    if let Some(wrong) = row.cutkosky.filter(|number| *number != grasp.cutkosky) {
        return Err(Problem::Cutkosky { grasp: name.to_owned(), right: grasp.cutkosky, wrong });
    }
    let render = ManifestRow {
        file: file.to_owned(),
        hand_shape: row.hand_shape.unwrap_or("unknown").to_owned(),
        grasp: grasp.name.clone(),
        cutkosky: grasp.cutkosky,
        stage: row.stage.unwrap_or("grasp").parse()?,
        view: View {
            azimuth_deg: row.azimuth.unwrap_or(0.0),
            elevation_deg: row.elevation.unwrap_or(0.0),
            roll_deg: row.roll.unwrap_or(0.0),
        },
        camera_from_hand: row.orientation()?.ok_or_else(|| RowFault::empty("qx"))?,
        object: row.object.unwrap_or_default().to_owned(),
        seed: row.seed.unwrap_or(0),
    };
    match folder.join(file).is_file() {
        true => Ok(render),
        false => Err(Problem::MissingFile(render.file)),
    }
}

/// The rows as CSV text; floats are written so that they read back exactly.
pub(super) fn to_csv(rows: impl Iterator<Item = ManifestRow>) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (at, row) in rows.enumerate() {
        let q = row.camera_from_hand.coords;
        let fields = [
            ("file", row.file),
            ("hand_shape", row.hand_shape),
            ("grasp", row.grasp),
            ("cutkosky", row.cutkosky.to_string()),
            ("stage", row.stage.to_string()),
            ("azimuth", row.view.azimuth_deg.to_string()),
            ("elevation", row.view.elevation_deg.to_string()),
            ("roll", row.view.roll_deg.to_string()),
            ("qx", q.x.to_string()),
            ("qy", q.y.to_string()),
            ("qz", q.z.to_string()),
            ("qw", q.w.to_string()),
            ("object", row.object),
            ("seed", row.seed.to_string()),
        ];
        if at == 0 {
            writer.write_record(fields.each_ref().map(|(column, _)| *column))?;
        }
        writer.write_record(fields.map(|(_, value)| value))?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}
