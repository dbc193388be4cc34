//! How the search grows with the index: candidates, latency, recall, file size and build time
//! against the number of entries, for each hash.
//!
//! The paper promises that a query looks at N^(1/(1+eps)) of N entries. Here ever more hand shapes
//! are put into an index ([`data`]), each index is measured (`measure`), the results are kept as
//! they come ([`table`]), and the exponent that they follow ([`fit`]) is drawn beside the promised
//! one ([`plot`]).

pub mod data;
pub mod fit;
mod measure;
pub mod plot;
pub mod table;

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_canonical::Encoder;
use grasp_index::{AtomicFile, DescriptorParams};
use grasp_renders::RENDERER_VERSION;
use grasp_terminal::Progress;

use crate::interrupt;
use data::Data;
use measure::Truth;
use table::Row;

pub use measure::Hash;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Settings {
    /// What to index and to search for.
    pub data: Data,
    /// Numbers of entries, as near as whole hand shapes come to them.
    pub sizes: BTreeSet<u64>,
    /// The hashes, each with the largest number of entries that it is measured with.
    pub hashes: Vec<(Hash, u64)>,
    /// Where the table, the picture and, meanwhile, the descriptors go.
    pub out: PathBuf,
    /// What all randomness comes from.
    pub seed: u64,
}

/// Half-decade steps from 10^3.7 up to `largest`; `largest` alone, where it is below that.
#[must_use]
pub fn default_sizes(largest: u64) -> BTreeSet<u64> {
    let steps = (0..).map(|step| 10f64.powf(3.7 + 0.5 * f64::from(step)).round() as u64);
    let sizes: BTreeSet<u64> = steps.take_while(|&size| size <= largest).collect();
    if sizes.is_empty() { [largest].into() } else { sizes }
}

/// Measures what is not yet in the table at `out`, and writes table and picture after every
/// measurement. Calls `report_row` with each row, old or new.
///
/// # Errors
/// Where the folder holds results of other data, or files cannot be read or written.
/// [`crate::interrupt::Interrupted`] when the user asked to stop; what was measured is in the
/// table.
pub fn run(
    settings: &Settings,
    progress: Progress,
    report_row: &mut dyn FnMut(&Row),
) -> anyhow::Result<Vec<Row>> {
    fs::create_dir_all(&settings.out)
        .with_context(|| format!("cannot make the folder {}", settings.out.display()))?;
    let table = settings.out.join("scale.csv");
    let mut rows = table::read(&table)?;
    let data_name = settings.data.name(settings.seed)?;
    if let Some(other) = rows.iter().find(|row| row.data != data_name) {
        bail!(
            "{} has results of other data ({}, not {data_name}): name another folder with --out",
            table.display(),
            other.data
        );
    }
    // Before the smaller ones are measured.
    let most = settings.data.most()?;
    if let Some(size) = settings.sizes.iter().find(|size| **size > most) {
        bail!("the array holds {most} rows, and {size} are wanted: lower --sizes");
    }
    let work = Work::in_folder(settings)?;
    for &size in &settings.sizes {
        let hashes = settings.hashes.iter().filter(|(_, most)| size <= *most).map(|(hash, _)| *hash);
        let missing: Vec<Hash> = hashes
            .filter(|hash| !rows.iter().any(|row| row.size == size && row.hash == hash.name()))
            .collect();
        if missing.is_empty() {
            continue;
        }
        let prepared = data::prepare(&settings.data, settings.seed, size, &work.folder, progress)?;
        let mut truth: Option<Truth> = None;
        for hash in missing {
            let index = work.folder.join("scale.idx");
            let spinner = progress.spinner("measuring");
            spinner.set_message(format!("{} entries, {} hash", prepared.base.rows, hash.name()));
            let measured = measure::measure(&prepared, hash, settings.seed, &index, &mut truth);
            drop(spinner);
            // The index has served: the next one may need its room.
            let _ = fs::remove_file(&index);
            let row = Row { data: data_name.clone(), size, hash: hash.name().into(), ..measured? };
            report_row(&row);
            rows.push(row);
            rows.sort_by(|a, b| a.hash.cmp(&b.hash).then(a.size.cmp(&b.size)));
            table::write(&table, &rows)?;
            write_plot(&settings.out.join("scale.svg"), &rows)?;
            interrupt::check()?;
        }
    }
    work.done();
    write_plot(&settings.out.join("scale.svg"), &rows)?;
    Ok(rows)
}

/// Draws the picture anew from the table at `out`, and measures nothing. Returns the table's rows.
///
/// # Errors
/// Where the table is missing or empty, or files cannot be read or written.
pub fn redraw(out: &Path) -> anyhow::Result<Vec<Row>> {
    let table = out.join("scale.csv");
    let rows = table::read(&table)?;
    if rows.is_empty() {
        bail!("{} holds no results to draw: name their folder with --out", table.display());
    }
    write_plot(&out.join("scale.svg"), &rows)?;
    Ok(rows)
}

fn write_plot(path: &Path, rows: &[Row]) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    let written = file.write_all(plot::svg(rows).as_bytes());
    written.with_context(|| format!("cannot write {}", path.display()))?;
    Ok(file.commit()?)
}

/// The folder of what is needed only until everything is measured. It stays where the work was
/// stopped, so that hand shapes need not be rendered again.
struct Work {
    folder: PathBuf,
}

impl Work {
    fn in_folder(settings: &Settings) -> anyhow::Result<Self> {
        // Renders of another seed, or by another version, are not to be taken for these.
        let fingerprint = DescriptorParams::default().fingerprint();
        let key = Encoder::new().u64(settings.seed).u32(RENDERER_VERSION).u64(fingerprint).hash();
        let folder = settings.out.join(format!(".scale-{key:016x}"));
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        Ok(Self { folder })
    }

    fn done(self) {
        // Results are safe; what cannot be removed is in nobody's way.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_rise_in_half_decades_up_to_the_largest() {
        let sizes: Vec<u64> = default_sizes(501_188).into_iter().collect();
        assert_eq!(sizes, [5012, 15849, 50119, 158489, 501187]);
        assert_eq!(default_sizes(800), [800].into());
    }
}
