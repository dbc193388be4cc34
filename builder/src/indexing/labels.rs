//! A table of labels for vectors that came from elsewhere: one line an entry, in their order.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::{ClassInfo, KeptFields, NewEntry};
use grasp_labels::{REMARK, Row, RowFault, Table};
use grasp_renders::GraspSet;
use nalgebra::UnitQuaternion;

use super::names::Names;

/// A table whose every line has been read and checked once.
#[derive(Debug)]
pub(super) struct Labels {
    path: PathBuf,
    lines: u64,
    names: Names,
}

/// A line that has what the table's columns promise, not yet numbered.
struct Line<'r> {
    row: Row<'r>,
    grasp: &'r str,
    view_deg: [f32; 3],
    orientation: UnitQuaternion<f64>,
}

impl Labels {
    /// Reads the table once and checks every line. A grasp without a number of its own has the one
    /// that `grasps` gives its name, or else 0.
    pub(super) fn open(path: &Path, grasps: &GraspSet) -> anyhow::Result<Self> {
        let mut table = table(path)?;
        let kept = kept(&table).with_context(|| cannot_use(path))?;
        let mut names = Names { kept, ..Names::default() };
        let mut numbers: HashMap<String, Option<u8>> = HashMap::new();
        let mut lines = 0;
        while table.advance().with_context(|| at_line(path, &table))? {
            let mut take = || -> anyhow::Result<()> {
                let Line { row, grasp, .. } = Line::new(table.row()?, kept)?;
                names.add_hand_shape(row.hand_shape.unwrap_or_default())?;
                names.add_stage(row.stage.unwrap_or_default())?;
                match numbers.get_mut(grasp) {
                    None => drop(numbers.insert(grasp.to_owned(), row.cutkosky)),
                    Some(number) => match (*number, row.cutkosky) {
                        (Some(one), Some(other)) if one != other => {
                            bail!("grasp `{grasp}` is number {one} on a line before, and {other} here")
                        }
                        (one, other) => *number = one.or(other),
                    },
                }
                Ok(())
            };
            take().with_context(|| at_line(path, &table))?;
            lines += 1;
        }
        let class = |(name, number): (String, Option<u8>)| {
            let cutkosky = number.or_else(|| grasps.get(&name).map(|grasp| grasp.cutkosky)).unwrap_or(0);
            ClassInfo { name, cutkosky }
        };
        names.classes = numbers.into_iter().map(class).collect();
        names.sort_classes();
        Ok(Self { path: path.to_owned(), lines, names })
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
        Ok(Entries { labels: self, table: table(&self.path)? })
    }
}

/// Entries without their descriptors.
pub(super) struct Entries<'l> {
    labels: &'l Labels,
    table: Table<File>,
}

impl Entries<'_> {
    /// Passes over the next `lines` lines.
    pub(super) fn skip(&mut self, lines: usize) -> anyhow::Result<()> {
        for _ in 0..lines {
            self.advance()?;
        }
        Ok(())
    }

    pub(super) fn next(&mut self) -> anyhow::Result<NewEntry> {
        self.advance()?;
        let Labels { path, names, .. } = self.labels;
        let entry = || -> anyhow::Result<NewEntry> {
            let Line { row, grasp, view_deg, orientation } = Line::new(self.table.row()?, names.kept)?;
            let [azimuth_deg, elevation_deg, roll_deg] = view_deg;
            Ok(NewEntry {
                class: names.class(grasp)?,
                stage: names.stage(row.stage.unwrap_or_default())?,
                hand_shape: names.hand_shape(row.hand_shape.unwrap_or_default())?,
                object: row.object.unwrap_or_default().to_owned(),
                file: row.file.unwrap_or_default().to_owned(),
                azimuth_deg,
                elevation_deg,
                roll_deg,
                orientation,
                ..NewEntry::default()
            })
        };
        entry().with_context(|| at_line(path, &self.table))
    }

    /// Goes on to the next line, which was there when the table was checked.
    fn advance(&mut self) -> anyhow::Result<()> {
        let path = &self.labels.path;
        if !self.table.advance().with_context(|| at_line(path, &self.table))? {
            bail!("{} was truncated while it was read", path.display());
        }
        Ok(())
    }
}

impl<'r> Line<'r> {
    fn new(row: Row<'r>, kept: KeptFields) -> anyhow::Result<Self> {
        let grasp = row.grasp.context("no grasp")?;
        // The entries of an index are right hands; a left one's picture is flipped before it is
        // described.
        if let Some(hand) = row.hand.filter(|hand| *hand != "right") {
            bail!(
                "hand is `{hand}`: an index holds right hands, so flip left ones before they are described"
            );
        }
        let needed = |column, angle: Option<f64>| {
            angle.map(|angle| angle as f32).ok_or_else(|| RowFault::empty(column))
        };
        let view_deg = match kept.views {
            true => [
                needed("azimuth", row.azimuth)?,
                needed("elevation", row.elevation)?,
                row.roll.unwrap_or(0.0) as f32,
            ],
            false => [0.0; 3],
        };
        let orientation = match kept.orientations {
            true => row.orientation()?.ok_or_else(|| RowFault::empty("qx"))?,
            false => UnitQuaternion::identity(),
        };
        Ok(Self { row, grasp, view_deg, orientation })
    }
}

/// What the columns of a table say of each entry.
fn kept(table: &Table<File>) -> anyhow::Result<KeptFields> {
    if !table.has("grasp") {
        bail!("it has no column `grasp`, only {}", table.columns().collect::<Vec<_>>().join(", "));
    }
    for group in [&["qx", "qy", "qz", "qw"][..], &["azimuth", "elevation"]] {
        let missing: Vec<&str> = group.iter().copied().filter(|name| !table.has(name)).collect();
        if !missing.is_empty() && missing.len() < group.len() {
            bail!(
                "of the columns {}, which go together, {} is missing",
                group.join(", "),
                missing.join(", ")
            );
        }
    }
    Ok(KeptFields {
        labels: true,
        orientations: table.has("qw"),
        views: table.has("azimuth"),
        files: table.has("file"),
        sources: false,
    })
}

fn table(path: &Path) -> anyhow::Result<Table<File>> {
    let file = File::open(path).with_context(|| cannot_use(path))?;
    Table::new(file, Some(REMARK)).with_context(|| cannot_use(path))
}

fn cannot_use(path: &Path) -> String {
    format!("cannot use the labels {}", path.display())
}

fn at_line(path: &Path, table: &Table<File>) -> String {
    format!("{}, line {}", path.display(), table.line())
}
