//! Building an index and writing it.
//!
//! Descriptors are the bulk of an index. They are written as they come, straight to where they lie in the file
//! ([`sink`]), and mapped from there when the hash is made of them ([`built`]); of the rest of an entry a few bytes stay
//! in memory ([`columns`]). The header comes last: until then zeros stand in its place, which make no index.

mod built;
mod columns;
mod sink;

use super::atomic::{AtomicFile, WriteError};
use super::catalogue::Catalogue;
use super::header::{self, Header};
use super::input::{BuildError, IndexParams, NewEntry, Phase, Summary};
use super::sections::{Section, SectionKind};
use crate::search::Rows;
use crate::search::random::MAX_PLANES;
use crate::search::tune::HashParams;
use built::Built;
use columns::Columns;
use sink::Sink;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// Collects entries and writes them as an index. Entries keep the order in which they are added: the same entries in the
/// same order, with the same parameters, make the same bytes.
///
/// [`Self::create`] writes to the disk from the first entry on, so that an index may be larger than the memory: what is
/// held is some 60 bytes an entry, the entries' names, and the hash tables at the end. [`Self::new`] holds everything.
#[derive(Debug)]
pub struct IndexWriter {
    params: IndexParams,
    columns: Columns,
    /// The file's own bytes: room for the header, and the descriptors so far.
    out: Sink,
    /// The thumbnails so far, which follow when the descriptors are complete.
    thumbnails: Sink,
    /// What `out` writes to; `None` in memory.
    file: Option<AtomicFile>,
}

impl IndexWriter {
    /// An index in memory, without entries: [`Self::finish_bytes`] makes its bytes.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range.
    pub fn new(params: IndexParams) -> Result<Self, BuildError> {
        check_params(&params)?;
        Self::start(params, Sink::memory(), Sink::memory(), None)
    }

    /// An index without entries that [`Self::finish`] puts at `path`: the file there, if any, is then replaced in one
    /// step, and stays as it is where that does not come to pass.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range or the file cannot be written.
    pub fn create(path: impl AsRef<Path>, params: IndexParams) -> Result<Self, BuildError> {
        check_params(&params)?;
        Self::create_in(AtomicFile::create(path.as_ref())?, params)
    }

    /// As [`Self::create`], in a file that was started (and locked) before the parameters were known. Nothing may have been
    /// written to it.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range or the file cannot be written.
    pub fn create_in(file: AtomicFile, params: IndexParams) -> Result<Self, BuildError> {
        check_params(&params)?;
        let sinks = || -> io::Result<_> {
            let thumbnails = match params.thumbnail_side {
                0 => Sink::memory(),
                _ => Sink::unnamed(file.folder())?,
            };
            Ok((Sink::file(file.handle()?), thumbnails))
        };
        let (out, thumbnails) = sinks().map_err(|source| failed(Some(&file), source))?;
        Self::start(params, out, thumbnails, Some(file))
    }

    fn start(
        params: IndexParams,
        mut out: Sink,
        thumbnails: Sink,
        file: Option<AtomicFile>,
    ) -> Result<Self, BuildError> {
        let started = out.append(&[0; header::LENGTH]).and_then(|()| out.open());
        started.map_err(|source| failed(file.as_ref(), source))?;
        Ok(Self { params, columns: Columns::default(), out, thumbnails, file })
    }

    /// What the index is to be like.
    pub fn params(&self) -> &IndexParams {
        &self.params
    }

    /// Adds to [`IndexParams::provenance`] what is known only when all entries are in.
    pub fn add_provenance(&mut self, provenance: impl IntoIterator<Item = (String, String)>) {
        self.params.provenance.extend(provenance);
    }

    /// How many entries have been added.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether no entry has been added yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds an entry.
    ///
    /// # Errors
    /// [`BuildError::Entry`], where it does not fit the index's parameters; the index is then as it was.
    /// [`BuildError::Write`], where the disk is full; the index is then lost.
    pub fn push(&mut self, entry: NewEntry) -> Result<(), BuildError> {
        if let Err(what) = check_entry(&self.params, &entry) {
            return Err(BuildError::Entry { file: entry.file, what });
        }
        self.columns.push(&entry)?;
        let mut write = || -> io::Result<()> {
            self.out.append(bytemuck::cast_slice(&entry.descriptor))?;
            match &entry.thumbnail {
                Some(thumbnail) => self.thumbnails.append(thumbnail),
                None => self.thumbnails.append(&vec![0; pixels(&self.params)]),
            }
        };
        write().map_err(|source| failed(self.file.as_ref(), source))
    }

    /// Builds the tables and puts the index in its place. `progress` hears of every phase with a share from 0 to 1, and
    /// stops the work by breaking.
    ///
    /// # Errors
    /// [`BuildError`]; the file at the path is then as it was.
    pub fn finish(mut self, progress: &dyn Fn(Phase, f64) -> ControlFlow<()>) -> Result<Summary, BuildError> {
        let file = self.file.take().ok_or(BuildError::InMemory)?;
        let summary = self.complete(progress).map_err(|error| match error {
            Failure::Io(source) => failed(Some(&file), source),
            Failure::Build(error) => error,
        })?;
        file.commit()?;
        Ok(summary)
    }

    /// Builds the tables and gives the bytes of the index, those that [`Self::finish`] would write.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn finish_bytes(mut self) -> Result<Vec<u8>, BuildError> {
        let file = self.file.take();
        let mut bytes = || -> Result<Vec<u8>, Failure> {
            self.complete(&|_, _| ControlFlow::Continue(()))?;
            Ok(self.out.written()?.to_vec())
        };
        bytes().map_err(|error| match error {
            Failure::Io(source) => failed(file.as_ref(), source),
            Failure::Build(error) => error,
        })
    }

    /// Writes all that follows the descriptors, and then the header.
    fn complete(&mut self, progress: &dyn Fn(Phase, f64) -> ControlFlow<()>) -> Result<Summary, Failure> {
        if self.is_empty() {
            return Err(BuildError::Empty.into());
        }
        let descriptors = self.out.close(SectionKind::Descriptors);
        let built = {
            let written = self.out.written()?;
            let values = written.get(header::LENGTH..).unwrap_or(&[]);
            let rows = Rows { values: bytemuck::cast_slice(values), dim: self.params.descriptor.dim() };
            Built::new(rows, &self.columns, &self.params, progress)?
        };
        let sections = self.sections(descriptors, &built, progress)?;
        let catalogue = self.catalogue(&built, sections);
        let archive = rkyv::to_bytes::<rkyv::rancor::Error>(&catalogue).map_err(io::Error::other)?;
        self.out.open()?;
        let header = Header {
            file_length: self.out.len() + archive.len() as u64,
            catalogue_offset: self.out.len(),
            catalogue_length: archive.len() as u64,
            catalogue_hash: xxh3_64(&archive),
        };
        self.out.append(&archive)?;
        self.out.finish(&header.to_bytes())?;
        Ok(Summary {
            entries: self.len() as u64,
            bytes: self.out.len(),
            sigma: built.sigma,
            hash: built.hash,
            measured: built.measured,
        })
    }

    /// Writes the sections after the descriptors, and lists all.
    fn sections(
        &mut self,
        descriptors: Section,
        built: &Built,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Vec<Section>, Failure> {
        let Self { columns, out, thumbnails, .. } = self;
        let thumbnails = thumbnails.written()?;
        let bytes = |kind| match kind {
            SectionKind::Thumbnails => &*thumbnails,
            _ => built.section(columns, kind),
        };
        let total = SectionKind::ALL.iter().map(|&kind| bytes(kind).len()).sum::<usize>().max(1);
        let mut written = 0;
        let mut wrote = |bytes: usize| {
            written += bytes;
            match progress(Phase::Write, written as f64 / total as f64) {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(Failure::Build(BuildError::Stopped)),
            }
        };
        let section = |&kind: &SectionKind| match kind {
            SectionKind::Descriptors => Ok(descriptors),
            _ => out.section(kind, bytes(kind), &mut wrote),
        };
        SectionKind::ALL.iter().map(section).collect()
    }

    fn catalogue(&self, built: &Built, sections: Vec<Section>) -> Catalogue {
        let params = &self.params;
        Catalogue {
            entries: self.len() as u64,
            dim: params.descriptor.dim() as u32,
            descriptor: params.descriptor,
            descriptor_fingerprint: params.descriptor.fingerprint(),
            classes: params.classes.clone(),
            hand_shapes: params.hand_shapes.clone(),
            stages: params.stages.clone(),
            objects: self.columns.objects.offsets.len() as u32 - 1,
            sigma: built.sigma,
            calibration: params.calibration,
            seed: params.seed,
            hash: built.hash,
            measured: built.measured,
            thumbnail_side: params.thumbnail_side,
            provenance: params.provenance.clone(),
            sections,
        }
    }
}

/// What stops the writing: the caller, who knows the file, names it.
enum Failure {
    Io(io::Error),
    Build(BuildError),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

fn failed(file: Option<&AtomicFile>, source: io::Error) -> BuildError {
    let path = file.map_or_else(|| PathBuf::from("memory"), |file| file.path().to_path_buf());
    WriteError::Io { path, source }.into()
}

/// The pixels of a thumbnail.
fn pixels(params: &IndexParams) -> usize {
    (params.thumbnail_side as usize).pow(2)
}

fn check_params(params: &IndexParams) -> Result<(), BuildError> {
    params.descriptor.validate()?;
    if params.classes.is_empty() || params.hand_shapes.is_empty() || params.stages.is_empty() {
        return Err(BuildError::Params("an index needs at least one class, one hand shape and one stage"));
    }
    if params.classes.len() > 1 << 16 || params.hand_shapes.len() > 1 << 16 || params.stages.len() > 1 << 8 {
        return Err(BuildError::Params(
            "at most 65,536 classes, 65,536 hand shapes and 256 stages can be numbered",
        ));
    }
    if params.thumbnail_side > 1024 {
        return Err(BuildError::Params("thumbnails of more than 1024 pixels a side are none"));
    }
    if !(params.calibration.sigma_scale > 0.0 && params.calibration.sigma_scale.is_finite()) {
        return Err(BuildError::Params("the factor on sigma must be a positive number"));
    }
    if params.calibration.k == 0 {
        return Err(BuildError::Params("at least one neighbour must vote"));
    }
    if let HashParams::Fixed { k, t, buckets } = params.hash
        && !((1..=MAX_PLANES).contains(&k) && (1..=1024).contains(&t) && (1..=1 << 20).contains(&buckets))
    {
        return Err(BuildError::Params("K is 1 to 64, T 1 to 1024, and H 1 to 1,048,576"));
    }
    Ok(())
}

fn check_entry(params: &IndexParams, entry: &NewEntry) -> Result<(), String> {
    let dim = params.descriptor.dim();
    if entry.descriptor.len() != dim {
        return Err(format!("its descriptor has {} values, the index's have {dim}", entry.descriptor.len()));
    }
    if let Some(at) = entry.descriptor.iter().position(|value| !value.is_finite()) {
        return Err(format!("value {at} of its descriptor is not a finite number"));
    }
    let views = [entry.azimuth_deg, entry.elevation_deg, entry.roll_deg];
    if !views.iter().all(|angle| angle.is_finite()) {
        return Err("its view is not made of finite numbers".into());
    }
    let is_unit = (entry.orientation.norm() - 1.0).abs() < 1e-4;
    if !is_unit {
        return Err("its orientation is no unit quaternion".into());
    }
    for (what, number, count) in [
        ("class", usize::from(entry.class), params.classes.len()),
        ("stage", usize::from(entry.stage), params.stages.len()),
        ("hand shape", usize::from(entry.hand_shape), params.hand_shapes.len()),
    ] {
        if number >= count {
            return Err(format!("its {what} is number {number}, and the index has {count}"));
        }
    }
    match &entry.thumbnail {
        Some(thumbnail) if thumbnail.len() != pixels(params) => {
            Err(format!("its thumbnail has {} pixels, the index's have {}", thumbnail.len(), pixels(params)))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
