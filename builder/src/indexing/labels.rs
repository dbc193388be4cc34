//! A table of labels for vectors that came from elsewhere: one line an entry, in their order.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use csv::StringRecord;
use grasp_index::{ClassInfo, Kept, NewEntry};
use grasp_renders::GraspSet;
use nalgebra::{Quaternion, UnitQuaternion};

use super::names::Names;

/// How far a quaternion's length may be from 1: three decimals are enough.
const UNIT_TOLERANCE: f64 = 1e-2;

/// A table whose every line has been read and checked once.
#[derive(Debug)]
pub(super) struct Labels {
    path: PathBuf,
    columns: Columns,
    lines: u64,
    names: Names,
}

/// Where the table has what.
#[derive(Clone, Debug)]
struct Columns(HashMap<String, usize>);

/// One line, not yet numbered.
struct Line<'r> {
    grasp: &'r str,
    cutkosky: Option<u8>,
    hand_shape: &'r str,
    stage: &'r str,
    object: &'r str,
    file: &'r str,
    view: [f32; 3],
    orientation: UnitQuaternion<f64>,
}

impl Labels {
    /// Reads the table once and checks every line. A grasp without a number of its own has the one
    /// that `grasps` gives its name, or else 0.
    pub(super) fn open(path: &Path, grasps: &GraspSet) -> anyhow::Result<Self> {
        let mut reader = reader(path)?;
        let headers = reader.headers().with_context(|| cannot_read(path))?.clone();
        let columns = Columns::of(&headers).with_context(|| cannot_read(path))?;
        let mut names = Names { kept: columns.kept(), ..Names::default() };
        let mut numbers: HashMap<String, Option<u8>> = HashMap::new();
        let (mut record, mut lines) = (StringRecord::new(), 0);
        while read(&mut reader, &mut record, path)? {
            let mut take = || -> anyhow::Result<()> {
                let line = columns.line(&record)?;
                names.hand_shapes.add(line.hand_shape)?;
                names.stages.add(line.stage)?;
                match numbers.get_mut(line.grasp) {
                    None => drop(numbers.insert(line.grasp.to_owned(), line.cutkosky)),
                    Some(number) => match (*number, line.cutkosky) {
                        (Some(one), Some(other)) if one != other => {
                            bail!("grasp `{}` is number {one} on a line before, and {other} here", line.grasp)
                        }
                        (one, other) => *number = one.or(other),
                    },
                }
                Ok(())
            };
            take().with_context(|| at_line(path, &record))?;
            lines += 1;
        }
        if names.stages.names.len() > 1 << 8 {
            bail!(
                "{} names {} stages: at most 256 can be numbered",
                path.display(),
                names.stages.names.len()
            );
        }
        let class = |(name, number): (String, Option<u8>)| {
            let cutkosky = number.or_else(|| grasps.get(&name).map(|grasp| grasp.cutkosky)).unwrap_or(0);
            ClassInfo { name, cutkosky }
        };
        names.classes = numbers.into_iter().map(class).collect();
        names.classes.sort_by(|a, b| (a.cutkosky, &a.name).cmp(&(b.cutkosky, &b.name)));
        Ok(Self { path: path.to_owned(), columns, lines, names })
    }

    /// How many entries it labels.
    pub(super) fn len(&self) -> u64 {
        self.lines
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn names(&self) -> &Names {
        &self.names
    }

    /// Reads it once more, line by line.
    pub(super) fn entries(&self) -> anyhow::Result<Entries<'_>> {
        Ok(Entries { labels: self, reader: reader(&self.path)?, record: StringRecord::new() })
    }
}

/// Entries without their descriptors.
pub(super) struct Entries<'l> {
    labels: &'l Labels,
    reader: csv::Reader<File>,
    record: StringRecord,
}

impl Entries<'_> {
    /// Passes over the next `lines` lines.
    pub(super) fn skip(&mut self, lines: usize) -> anyhow::Result<()> {
        for _ in 0..lines {
            read(&mut self.reader, &mut self.record, &self.labels.path)?;
        }
        Ok(())
    }

    pub(super) fn next(&mut self) -> anyhow::Result<NewEntry> {
        let Labels { path, columns, names, .. } = self.labels;
        if !read(&mut self.reader, &mut self.record, path)? {
            bail!("{} was truncated while it was read", path.display());
        }
        let entry = || -> anyhow::Result<NewEntry> {
            let line = columns.line(&self.record)?;
            let [azimuth_deg, elevation_deg, roll_deg] = line.view;
            Ok(NewEntry {
                class: names.class(line.grasp)?,
                stage: names.stage(line.stage)?,
                hand_shape: names.hand_shape(line.hand_shape)?,
                object: line.object.to_owned(),
                file: line.file.to_owned(),
                azimuth_deg,
                elevation_deg,
                roll_deg,
                orientation: line.orientation,
                ..NewEntry::default()
            })
        };
        entry().with_context(|| at_line(path, &self.record))
    }
}

impl Columns {
    fn of(headers: &StringRecord) -> anyhow::Result<Self> {
        // Excel and others put a byte order mark before the first name.
        let names = headers.iter().map(|name| name.trim_start_matches('\u{feff}').to_owned());
        let columns = Self(names.zip(0..).collect());
        if !columns.has("grasp") {
            bail!("it has no column `grasp`, only {}", headers.iter().collect::<Vec<_>>().join(", "));
        }
        for group in [&["qx", "qy", "qz", "qw"][..], &["azimuth", "elevation"]] {
            let missing: Vec<&str> = group.iter().copied().filter(|name| !columns.has(name)).collect();
            if !missing.is_empty() && missing.len() < group.len() {
                bail!(
                    "of the columns {}, which go together, {} is missing",
                    group.join(", "),
                    missing.join(", ")
                );
            }
        }
        Ok(columns)
    }

    fn has(&self, column: &str) -> bool {
        self.0.contains_key(column)
    }

    fn kept(&self) -> Kept {
        Kept {
            labels: true,
            orientations: self.has("qw"),
            views: self.has("azimuth"),
            files: self.has("file"),
            sources: false,
        }
    }

    fn text<'r>(&self, record: &'r StringRecord, column: &str) -> &'r str {
        self.0.get(column).and_then(|&at| record.get(at)).unwrap_or_default()
    }

    fn number<N: std::str::FromStr>(&self, record: &StringRecord, column: &str) -> anyhow::Result<N> {
        let text = self.text(record, column);
        text.parse().ok().with_context(|| {
            format!("`{text}` in column `{column}` is not a number in the range of that column")
        })
    }

    fn line<'r>(&self, record: &'r StringRecord) -> anyhow::Result<Line<'r>> {
        let text = |column| self.text(record, column);
        if text("grasp").is_empty() {
            bail!("no grasp");
        }
        // The entries of an index are right hands; a left one's picture is flipped before it is
        // described.
        if !matches!(text("hand"), "" | "right") {
            bail!(
                "hand is `{}`: an index holds right hands, so flip left ones before they are described",
                text("hand")
            );
        }
        let angle = |column| -> anyhow::Result<f32> {
            let value: f32 = self.number(record, column)?;
            if !value.is_finite() {
                bail!("`{}` in column `{column}` is not a finite number", text(column));
            }
            Ok(value)
        };
        let optional = |column| if text(column).is_empty() { Ok(0.0) } else { angle(column) };
        Ok(Line {
            grasp: text("grasp"),
            cutkosky: match text("cutkosky") {
                "" => None,
                _ => Some(self.number(record, "cutkosky")?),
            },
            hand_shape: text("hand_shape"),
            stage: text("stage"),
            object: text("object"),
            file: text("file"),
            view: match self.has("azimuth") {
                true => [angle("azimuth")?, angle("elevation")?, optional("roll")?],
                false => [0.0; 3],
            },
            orientation: if self.has("qw") { self.orientation(record)? } else { UnitQuaternion::identity() },
        })
    }

    fn orientation(&self, record: &StringRecord) -> anyhow::Result<UnitQuaternion<f64>> {
        let part = |column| self.number::<f64>(record, column);
        let rotation = Quaternion::new(part("qw")?, part("qx")?, part("qy")?, part("qz")?);
        if (rotation.norm() - 1.0).abs() > UNIT_TOLERANCE || !rotation.norm().is_finite() {
            bail!(
                "qx, qy, qz, qw have length {:.4}: camera_from_hand must be a unit quaternion",
                rotation.norm()
            );
        }
        Ok(UnitQuaternion::new_normalize(rotation))
    }
}

fn reader(path: &Path) -> anyhow::Result<csv::Reader<File>> {
    let reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_path(path);
    reader.with_context(|| cannot_read(path))
}

fn read(reader: &mut csv::Reader<File>, record: &mut StringRecord, path: &Path) -> anyhow::Result<bool> {
    reader.read_record(record).with_context(|| cannot_read(path))
}

fn cannot_read(path: &Path) -> String {
    format!("cannot use the labels {}", path.display())
}

fn at_line(path: &Path, record: &StringRecord) -> String {
    format!("{}, line {}", path.display(), record.position().map_or(0, csv::Position::line))
}
