//! Entries as a Parquet file, which data frames and query engines read: a row an entry, in their
//! order.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use grasp_index::{AtomicFile, Catalogue, ClassInfo, Index, IndexParams, KeptFields, NewEntry, Originals};
use parquet::basic::Encoding;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use parquet::schema::types::ColumnPath;

use super::pause::pause;
use crate::shard::PartReader;

/// Bytes of descriptors in a row group, of which one is held at a time: enough for readers to work
/// on, little beside an index.
const GROUP: usize = 32 << 20;
/// Rows of a group, however short the descriptors are.
const MOST_ROWS: usize = 1 << 16;
/// Rows whose descriptors are written at a time.
const ROWS_AT_ONCE: usize = 256;

/// Writes all entries of an index to `path`: file, grasp, cutkosky, hand_shape, stage, object,
/// azimuth, elevation, roll, qx, qy, qz, qw, descriptor, of which those are left out that the index
/// does not keep. `wrote` hears how many rows were written.
///
/// # Errors
/// When the index keeps no descriptors, an entry makes no sense, or `path` cannot be written; it is
/// then as it was.
pub fn index_as_parquet(index: &Index, path: &Path, wrote: &dyn Fn(u64)) -> anyhow::Result<()> {
    let catalogue = index.catalogue();
    if catalogue.originals == Originals::None {
        bail!("the index keeps no descriptors: build it with --originals f32 or f16");
    }
    let entry = |id| -> anyhow::Result<NewEntry> {
        let entry = index.new_entry(id)?;
        Ok(NewEntry { orientation: index.entry(id)?.orientation.unwrap_or_default(), ..entry })
    };
    write(Names::from(catalogue), (0..index.len() as u32).map(entry), path, wrote).map(drop)
}

/// Writes all entries of a part to `path`, as [`index_as_parquet`] does those of an index, and
/// tells how many there are.
///
/// # Errors
/// When the part is damaged or `path` cannot be written; it is then as it was.
pub(crate) fn part_as_parquet(part: PartReader, path: &Path, wrote: &dyn Fn(u64)) -> anyhow::Result<u64> {
    let params = part.header().params.clone();
    let mut part = Some(part);
    let entries = std::iter::from_fn(|| match part.as_mut()?.next() {
        Ok(Ok(entry)) => Some(Ok(entry)),
        // After the last entry, or an error, comes nothing.
        other => {
            part = None;
            other.err().map(Err)
        }
    });
    write(Names::from(&params), entries, path, wrote)
}

/// What the numbers of entries mean, and what is known of them.
struct Names<'a> {
    kept: KeptFields,
    classes: &'a [ClassInfo],
    hand_shapes: &'a [String],
    stages: &'a [String],
}

impl<'a> From<&'a Catalogue> for Names<'a> {
    fn from(Catalogue { kept, classes, hand_shapes, stages, .. }: &'a Catalogue) -> Self {
        Self { kept: *kept, classes, hand_shapes, stages }
    }
}

impl<'a> From<&'a IndexParams> for Names<'a> {
    fn from(IndexParams { kept, classes, hand_shapes, stages, .. }: &'a IndexParams) -> Self {
        Self { kept: *kept, classes, hand_shapes, stages }
    }
}

impl Names<'_> {
    fn class(&self, entry: &NewEntry) -> Option<&ClassInfo> {
        self.classes.get(usize::from(entry.class))
    }
}

/// What a column says of an entry.
#[derive(Clone, Copy)]
enum Column {
    Text(for<'e> fn(&'e Names<'_>, &'e NewEntry) -> &'e str),
    Number(fn(&Names<'_>, &NewEntry) -> i32),
    Angle(fn(&NewEntry) -> f32),
    Part(fn(&NewEntry) -> f64),
    Descriptor,
}

/// The columns by name; the names are those of the labels' table.
fn columns(kept: KeptFields) -> Vec<(&'static str, Column)> {
    let mut columns: Vec<(&str, Column)> = Vec::new();
    if kept.files {
        columns.push(("file", Column::Text(|_, entry| &entry.file)));
    }
    if kept.labels {
        columns.extend([
            ("grasp", Column::Text(|names, entry| names.class(entry).map_or("", |class| &class.name))),
            (
                "cutkosky",
                Column::Number(|names, entry| names.class(entry).map_or(0, |class| class.cutkosky.into())),
            ),
            ("hand_shape", Column::Text(|names, entry| name(names.hand_shapes, entry.hand_shape.into()))),
            ("stage", Column::Text(|names, entry| name(names.stages, entry.stage.into()))),
            ("object", Column::Text(|_, entry| &entry.object)),
        ]);
    }
    if kept.views {
        columns.extend([
            ("azimuth", Column::Angle(|entry| entry.azimuth_deg)),
            ("elevation", Column::Angle(|entry| entry.elevation_deg)),
            ("roll", Column::Angle(|entry| entry.roll_deg)),
        ]);
    }
    if kept.orientations {
        columns.extend([
            ("qx", Column::Part(|entry| entry.orientation.i)),
            ("qy", Column::Part(|entry| entry.orientation.j)),
            ("qz", Column::Part(|entry| entry.orientation.k)),
            ("qw", Column::Part(|entry| entry.orientation.w)),
        ]);
    }
    columns.push(("descriptor", Column::Descriptor));
    columns
}

fn name(names: &[String], at: usize) -> &str {
    names.get(at).map_or("", String::as_str)
}

impl Column {
    fn schema(self, name: &str) -> String {
        match self {
            Self::Text(_) => format!("required binary {name} (string);"),
            Self::Number(_) => format!("required int32 {name};"),
            Self::Angle(_) => format!("required float {name};"),
            Self::Part(_) => format!("required double {name};"),
            Self::Descriptor => {
                format!(
                    "required group {name} (list) {{ repeated group list {{ required float element; }} }}"
                )
            }
        }
    }

    fn write(
        self,
        names: &Names<'_>,
        entries: &[NewEntry],
        column: &mut SerializedColumnWriter<'_>,
    ) -> parquet::errors::Result<()> {
        match self {
            Self::Text(text) => {
                let value = |entry| ByteArray::from(text(names, entry));
                let values: Vec<ByteArray> = entries.iter().map(value).collect();
                column.typed::<ByteArrayType>().write_batch(&values, None, None)?;
            }
            Self::Number(number) => {
                let values: Vec<i32> = entries.iter().map(|entry| number(names, entry)).collect();
                column.typed::<Int32Type>().write_batch(&values, None, None)?;
            }
            Self::Angle(angle) => {
                let values: Vec<f32> = entries.iter().map(angle).collect();
                column.typed::<FloatType>().write_batch(&values, None, None)?;
            }
            Self::Part(part) => {
                let values: Vec<f64> = entries.iter().map(part).collect();
                column.typed::<DoubleType>().write_batch(&values, None, None)?;
            }
            Self::Descriptor => {
                for entries in entries.chunks(ROWS_AT_ONCE) {
                    let values: Vec<f32> =
                        entries.iter().flat_map(|entry| &entry.descriptor).copied().collect();
                    // A value starts a list or goes on with it, and none is missing.
                    let goes_on = |entry: &NewEntry| (0..entry.descriptor.len()).map(|at| i16::from(at > 0));
                    let repeated: Vec<i16> = entries.iter().flat_map(goes_on).collect();
                    let defined = vec![1; values.len()];
                    column.typed::<FloatType>().write_batch(&values, Some(&defined), Some(&repeated))?;
                }
            }
        }
        Ok(())
    }
}

/// Writes entries in groups of rows, and tells how many there were.
fn write(
    names: Names<'_>,
    entries: impl Iterator<Item = anyhow::Result<NewEntry>>,
    path: &Path,
    wrote: &dyn Fn(u64),
) -> anyhow::Result<u64> {
    let mut file = AtomicFile::create(path)?;
    let cannot = || format!("cannot write {}", path.display());
    let columns = columns(names.kept);
    let fields: String = columns.iter().map(|(name, column)| column.schema(name)).collect();
    let schema = parse_message_type(&format!("message grasp {{ {fields} }}")).with_context(cannot)?;
    let mut writer = SerializedFileWriter::new(&mut file, Arc::new(schema), Arc::new(properties()))
        .with_context(cannot)?;
    let mut rows = 0;
    let mut group: Vec<NewEntry> = Vec::new();
    let mut put = |group: &mut Vec<NewEntry>| -> anyhow::Result<()> {
        let written = writer.next_row_group().and_then(|row_group| put(&names, &columns, group, row_group));
        written.with_context(cannot)?;
        group.clear();
        Ok(())
    };
    for entry in entries {
        let entry = entry?;
        let enough = (GROUP / (4 * entry.descriptor.len().max(1))).clamp(1, MOST_ROWS);
        group.push(entry);
        rows += 1;
        pause(rows, wrote)?;
        if group.len() >= enough {
            put(&mut group)?;
        }
    }
    if !group.is_empty() {
        put(&mut group)?;
    }
    writer.close().with_context(cannot)?;
    file.commit()?;
    Ok(rows)
}

fn put(
    names: &Names<'_>,
    columns: &[(&str, Column)],
    entries: &[NewEntry],
    mut group: SerializedRowGroupWriter<'_, &mut AtomicFile>,
) -> parquet::errors::Result<()> {
    for (_, column) in columns {
        if let Some(mut writer) = group.next_column()? {
            column.write(names, entries, &mut writer)?;
            writer.close()?;
        }
    }
    group.close()?;
    Ok(())
}

/// Not compressed: of what takes space, the descriptors, no codec saves a tenth.
fn properties() -> WriterProperties {
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("grasp-builder ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_statistics_enabled(EnabledStatistics::Chunk);
    let descriptor = ColumnPath::from(["descriptor", "list", "element"].map(str::to_owned).to_vec());
    properties = properties.set_column_statistics_enabled(descriptor.clone(), EnabledStatistics::None);
    // Values of which hardly any comes twice want no dictionary.
    for column in ["file", "qx", "qy", "qz", "qw"].map(ColumnPath::from).into_iter().chain([descriptor]) {
        properties = properties
            .set_column_dictionary_enabled(column.clone(), false)
            .set_column_encoding(column, Encoding::PLAIN);
    }
    properties.build()
}
