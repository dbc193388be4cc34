//! What an index holds, written as other programs read it.

#[cfg_attr(not(feature = "parquet"), path = "without_parquet.rs")]
mod parquet;
mod pause;

use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::{AtomicFile, Catalogue, Entry, Index, Originals};
use grasp_labels::REMARK;

pub use self::parquet::index_as_parquet;
pub(crate) use self::parquet::part_as_parquet;
use crate::array;
use pause::pause;

/// Writes the descriptors as an array in `.npy` format, a row an entry. `wrote` hears how many
/// entries were written.
///
/// # Errors
/// When the index keeps none, or `path` cannot be written; it is then as it was.
pub fn descriptors(index: &Index, path: &Path, wrote: &dyn Fn(u64)) -> anyhow::Result<()> {
    if index.catalogue().originals == Originals::None {
        bail!("the index keeps no descriptors: build it with --originals f32 or f16");
    }
    array::write(path, index.len() as u64, index.dim(), |at, values| {
        pause(at, wrote)?;
        let row = index.descriptor(at as u32).with_context(|| format!("entry {at} has no descriptor"))?;
        values.extend_from_slice(&row);
        Ok(())
    })
}

/// Writes what is known of the entries as a table, a line an entry, in the form that `build
/// --labels` reads. `wrote` hears how many entries were written.
///
/// # Errors
/// When the index has no labels, one of them makes no sense, or `path` cannot be written; it is
/// then as it was.
pub fn labels(index: &Index, path: &Path, wrote: &dyn Fn(u64)) -> anyhow::Result<()> {
    let catalogue = index.catalogue();
    if !catalogue.kept.labels {
        bail!("the index has no labels: it was built of vectors alone");
    }
    let mut file = AtomicFile::create(path)?;
    let cannot = || format!("cannot write {}", path.display());
    // A value that begins as a remark does is quoted, so that it is read again.
    let mut table = csv::WriterBuilder::new().comment(Some(REMARK)).from_writer(BufWriter::new(&mut file));
    for id in 0..index.len() as u32 {
        pause(u64::from(id), wrote)?;
        let (columns, values): (Vec<_>, Vec<_>) = fields(catalogue, &index.entry(id)?).into_iter().unzip();
        if id == 0 {
            table.write_record(columns).with_context(cannot)?;
        }
        table.write_record(values).with_context(cannot)?;
    }
    table
        .into_inner()
        .map_err(|error| error.into_error())
        .and_then(|mut out| out.flush())
        .with_context(cannot)?;
    Ok(file.commit()?)
}

/// What is known of an entry, by column.
fn fields(catalogue: &Catalogue, entry: &Entry<'_>) -> Vec<(&'static str, String)> {
    let class = entry.class.and_then(|class| catalogue.classes.get(usize::from(class)));
    let (grasp, cutkosky) = class.map_or_else(Default::default, |class| (class.name.clone(), class.cutkosky));
    let mut fields = vec![
        ("grasp", grasp),
        ("cutkosky", cutkosky.to_string()),
        ("hand_shape", entry.hand_shape.to_owned()),
        ("stage", entry.stage.to_owned()),
        ("object", entry.object.to_owned()),
    ];
    if catalogue.kept.files {
        fields.insert(0, ("file", entry.file.to_owned()));
    }
    let angles = entry.view_deg.iter().flatten().map(ToString::to_string);
    fields.extend(["azimuth", "elevation", "roll"].into_iter().zip(angles));
    // As finely as the index keeps it.
    let parts = entry.orientation.iter().flat_map(|rotation| rotation.coords.iter());
    fields.extend(["qx", "qy", "qz", "qw"].into_iter().zip(parts.map(|part| format!("{part:.7}"))));
    fields
}
