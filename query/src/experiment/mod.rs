//! Experiments over labelled pictures, as tables and drawings: [`paper`] repeats those of the
//! paper, [`shapes`] asks what more hand shapes in the index are worth, [`unknown`] how well other
//! hands are distinguished from known ones, [`sequence`] what the frames before are worth,
//! [`steadiness`] how much small changes of a picture matter. [`trust`] fits how far an answer
//! about a camera picture is to be trusted, [`opening`] what hands look like before they hold
//! something, and [`report`] makes one page of somebody's own pictures. [`robustness`] asks how far
//! a robot's grasp may be off, and [`imitation`] runs the whole chain, from the picture to the robot
//! that lifts the object.

#[cfg(feature = "simulate")]
pub mod imitation;
pub mod opening;
pub mod paper;
pub mod report;
#[cfg(feature = "simulate")]
pub mod robustness;
pub mod sequence;
pub mod shapes;
pub mod steadiness;
pub mod trust;
pub mod unknown;

use std::fs;
use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use grasp_index::AtomicFile;
use serde::Serialize;

use crate::evaluate::labels::Kind;

/// Both kinds of pictures, in the order of tables and drawings.
const KINDS: [Kind; 2] = [Kind::Segmented, Kind::Camera];

/// Writes files of results into a folder, which is made where there is none.
fn write_files<const N: usize>(folder: &Path, names: [&str; N], bytes: [Vec<u8>; N]) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    names.iter().zip(&bytes).try_for_each(|(name, bytes)| write_file(&folder.join(name), bytes))
}

/// Figures as JSON to be read by people, too.
fn json_of(figures: &impl Serialize) -> anyhow::Result<Vec<u8>> {
    let mut json = serde_json::to_vec_pretty(figures)?;
    json.push(b'\n');
    Ok(json)
}

/// Writes a file of results, whole or not at all.
fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(file.commit()?)
}

/// A table with a header of the rows' field names.
fn csv_of(rows: impl IntoIterator<Item = impl Serialize>) -> anyhow::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for row in rows {
        table.serialize(row)?;
    }
    table.into_inner().map_err(|error| error.into_error().into())
}
