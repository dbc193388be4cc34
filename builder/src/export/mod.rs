//! What an index holds, written as other programs read it.

#[cfg_attr(not(feature = "parquet"), path = "without_parquet.rs")]
mod parquet;
mod pause;

use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::{AtomicFile, Catalogue, Entry, Index, Originals};

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
    let mut table = csv::Writer::from_writer(BufWriter::new(&mut file));
    table.write_record(columns(catalogue)).with_context(cannot)?;
    for id in 0..index.len() as u32 {
        pause(u64::from(id), wrote)?;
        table.write_record(fields(catalogue, &index.entry(id)?)).with_context(cannot)?;
    }
    table
        .into_inner()
        .map_err(|error| error.into_error())
        .and_then(|mut out| out.flush())
        .with_context(cannot)?;
    Ok(file.commit()?)
}

fn columns(catalogue: &Catalogue) -> Vec<&'static str> {
    let mut columns = vec!["grasp", "cutkosky", "hand_shape", "stage", "object"];
    if catalogue.kept.files {
        columns.insert(0, "file");
    }
    if catalogue.kept.views {
        columns.extend(["azimuth", "elevation", "roll"]);
    }
    if catalogue.kept.orientations {
        columns.extend(["qx", "qy", "qz", "qw"]);
    }
    columns
}

fn fields(catalogue: &Catalogue, entry: &Entry<'_>) -> Vec<String> {
    let class = entry.class.and_then(|class| catalogue.classes.get(usize::from(class)));
    let (grasp, cutkosky) = class.map_or_else(Default::default, |class| (class.name.clone(), class.cutkosky));
    let mut fields = vec![
        grasp,
        cutkosky.to_string(),
        entry.hand_shape.to_owned(),
        entry.stage.to_owned(),
        entry.object.to_owned(),
    ];
    if catalogue.kept.files {
        fields.insert(0, entry.file.to_owned());
    }
    fields.extend(entry.view_deg.iter().flatten().map(ToString::to_string));
    // As finely as the index keeps it.
    fields.extend(
        entry.orientation.iter().flat_map(|rotation| rotation.coords.iter()).map(|part| format!("{part:.7}")),
    );
    fields
}
