//! Building an index and writing it.
//!
//! Descriptors are the bulk of an index. They are written as they come, straight to where they lie
//! in the file ([`sink`]), and mapped from there when the hash is made of them ([`crate::model`]);
//! of the rest of an entry a few bytes stay in memory ([`columns`]). The header comes last: until
//! then zeros stand in its place, which make no index.

mod check;
mod columns;
mod hash_sections;
pub(crate) mod segment;
mod sink;
mod spread;

use super::atomic::{AtomicFile, WriteError};
use super::catalogue::Catalogue;
use super::header::{self, Header};
use super::input::{BuildError, IndexParams, NewEntry, Summary};
use super::sections::{ElementType, Section, SectionKind};
use super::wire;
use crate::model::{Model, ModelParams};
use crate::phase::Phase;
use crate::search::Originals;
use crate::search::build::{HashParams, RandomParams};
use crate::search::{Rows, Source};
use check::{check_entry, check_held_out, check_params, pixels};
use columns::Columns;
use grasp_network::Network;
use half::f16;
use sink::Sink;
use spread::Spread;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// Collects entries and writes them as an index. Entries keep the order in which they are added:
/// the same entries in the same order, with the same parameters, make the same bytes.
///
/// [`Self::create`] writes to the disk from the first entry on, so that an index may be larger than
/// the memory: what is held is up to 29 bytes an entry, the entries' names, and the hash tables at
/// the end. [`Self::new`] holds everything.
#[derive(Debug)]
pub struct IndexWriter {
    params: IndexParams,
    columns: Columns,
    spread: Spread,
    /// The file's own bytes: room for the header, and the descriptors so far.
    out: Sink,
    /// The descriptors so far, after as much room, where the file is to keep them in another form
    /// or not at all.
    rows: Option<Sink>,
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
        let rows = (params.originals != Originals::F32).then(Sink::memory);
        Self::start(params, Sink::memory(), rows, Sink::memory(), None)
    }

    /// An index without entries that [`Self::finish`] puts at `path`: the file there, if any, is
    /// then replaced in one step, and stays as it is where that does not come to pass.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range or the file cannot be written.
    pub fn create(path: impl AsRef<Path>, params: IndexParams) -> Result<Self, BuildError> {
        check_params(&params)?;
        Self::create_in(AtomicFile::create(path.as_ref())?, params)
    }

    /// As [`Self::create`], in a file that was started (and locked) before the parameters were
    /// known. Nothing may have been written to it.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range or the file cannot be written.
    pub fn create_in(file: AtomicFile, params: IndexParams) -> Result<Self, BuildError> {
        check_params(&params)?;
        let sinks = || -> io::Result<_> {
            let beside = || Sink::unnamed(file.folder());
            let rows = (params.originals != Originals::F32).then(beside).transpose()?;
            let thumbnails = if params.thumbnail_side > 0 { beside()? } else { Sink::memory() };
            Ok((Sink::file(file.handle()?), rows, thumbnails))
        };
        let (out, rows, thumbnails) = sinks().map_err(|source| failed(Some(&file), source))?;
        Self::start(params, out, rows, thumbnails, Some(file))
    }

    fn start(
        params: IndexParams,
        mut out: Sink,
        mut rows: Option<Sink>,
        thumbnails: Sink,
        file: Option<AtomicFile>,
    ) -> Result<Self, BuildError> {
        for sink in [Some(&mut out), rows.as_mut()].into_iter().flatten() {
            let started = sink.append(&[0; header::LENGTH]).and_then(|()| sink.open());
            started.map_err(|source| failed(file.as_ref(), source))?;
        }
        let (columns, spread) = (Columns::default(), Spread::default());
        Ok(Self { params, columns, spread, out, rows, thumbnails, file })
    }

    /// What the index is to be like.
    pub fn params(&self) -> &IndexParams {
        &self.params
    }

    /// Adds to [`IndexParams::provenance`] what is known only when all entries are in.
    pub fn add_provenance(&mut self, provenance: impl IntoIterator<Item = (String, String)>) {
        self.params.provenance.extend(provenance);
    }

    /// Gives [`IndexParams::held_out`] and [`IndexParams::held_out_classes`] when all entries are
    /// in.
    ///
    /// # Errors
    /// [`BuildError::Params`], where they are no rows of descriptors and their classes.
    pub fn hold_out(&mut self, held_out: Vec<f32>, classes: Vec<u16>) -> Result<(), BuildError> {
        check_held_out(&held_out, &classes, &self.params)?;
        self.params.held_out = held_out;
        self.params.held_out_classes = classes;
        Ok(())
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
    /// [`BuildError::Entry`], where it does not fit the index's parameters; the index is then as it
    /// was. [`BuildError::TooMany`], where entries or names can no longer be numbered.
    /// [`BuildError::Write`], where the disk is full; the index is then lost.
    pub fn push(&mut self, entry: NewEntry) -> Result<(), BuildError> {
        if let Err(what) = check_entry(&self.params, &entry) {
            return Err(BuildError::Entry { file: entry.file, what });
        }
        self.columns.push(&entry, self.params.kept)?;
        self.spread.add(&entry.descriptor);
        let mut write = || -> io::Result<()> {
            self.rows.as_mut().unwrap_or(&mut self.out).append(bytemuck::cast_slice(&entry.descriptor))?;
            match &entry.thumbnail {
                Some(thumbnail) => self.thumbnails.append(thumbnail),
                None => self.thumbnails.append(&vec![0; pixels(&self.params)]),
            }
        };
        write().map_err(|source| failed(self.file.as_ref(), source))
    }

    /// Builds the tables and puts the index in its place. `progress` hears of every phase with a
    /// share from 0 to 1, and stops the work by breaking.
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
        self.spread.check(self.params.originals)?;
        let Self { params, columns, out, rows, .. } = &mut *self;
        // Where the descriptors are kept as they are, they are in their place already.
        let in_place = rows.is_none().then(|| out.close(SectionKind::Descriptors, ElementType::F32));
        let written = match rows {
            Some(rows) => rows.written()?,
            None => out.written()?,
        };
        let values = written.get(header::LENGTH..).unwrap_or(&[]);
        let rows = Rows { values: bytemuck::cast_slice(values), dim: params.descriptor.dim() };
        check_count(params, rows.len())?;
        let model_params = ModelParams {
            hash: params.hash,
            originals: params.originals,
            labels: &columns.labels,
            classes: params.classes.len(),
            hand_shapes: params.hand_shapes.len(),
            held_out: &params.held_out,
            held_out_classes: &params.held_out_classes,
            calibration: params.calibration,
            seed: params.seed,
        };
        let model =
            Model::fit(Source { rows, file: &written }, &model_params, &|phase, share| match progress(
                phase, share,
            ) {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(BuildError::Stopped),
            })?;
        drop(written);
        let sections = self.sections(in_place, &model, progress)?;
        let catalogue = self.catalogue(&model, sections);
        Ok(Summary {
            entries: self.len() as u64,
            bytes: seal(&mut self.out, &catalogue, self.params.network.as_deref())?,
            sigma: model.sigma,
            calibration: model.calibration,
            hash: model.search.hash.info(),
            measured: model.search.measured,
        })
    }

    /// Writes the sections, but for descriptors that are in their place, and lists them.
    fn sections(
        &mut self,
        in_place: Option<Section>,
        model: &Model,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Vec<Section>, Failure> {
        let Self { params, columns, out, rows, thumbnails, .. } = self;
        let mut rows = rows.as_mut().filter(|_| params.originals == Originals::F16);
        let network = params.network.as_deref().map(Network::to_bytes).unwrap_or_default();
        let held = |kind| match kind {
            SectionKind::Network => &network,
            _ if kind.is_of_the_hash() => hash_sections::section(&model.search.hash, kind),
            _ => columns.section(kind, params.kept),
        };
        let kinds = SectionKind::of(&params.descriptor);
        let values = rows.as_ref().map_or(0, |rows| rows.len() - header::LENGTH as u64);
        let total =
            values + thumbnails.len() + kinds.iter().map(|&kind| held(kind).len() as u64).sum::<u64>();
        let mut written = 0;
        let mut wrote = |bytes: usize| {
            written += bytes;
            match progress(Phase::Write, written as f64 / total.max(1) as f64) {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(Failure::Build(BuildError::Stopped)),
            }
        };
        let mut section = |&kind: &SectionKind| {
            if let (SectionKind::Descriptors, Some(section)) = (kind, in_place) {
                return Ok(section);
            }
            out.open()?;
            match (kind, &mut rows) {
                (SectionKind::Descriptors, Some(rows)) => rows.pass_on(header::LENGTH, &mut |piece| {
                    append_halves(out, piece)?;
                    wrote(piece.len())
                })?,
                (SectionKind::Thumbnails, _) => thumbnails.pass_on(0, &mut |piece| {
                    out.append(piece)?;
                    wrote(piece.len())
                })?,
                _ => out.append_all(held(kind), &mut wrote)?,
            }
            Ok(out.close(kind, kind.element(params.originals)))
        };
        kinds.iter().map(&mut section).collect()
    }

    fn catalogue(&self, model: &Model, sections: Vec<Section>) -> Catalogue {
        let params = &self.params;
        Catalogue {
            entries: self.len() as u64,
            dim: params.descriptor.dim() as u32,
            descriptor: params.descriptor,
            descriptor_fingerprint: params.descriptor.fingerprint(),
            classes: params.classes.clone(),
            hand_shapes: params.hand_shapes.clone(),
            stages: params.stages.clone(),
            originals: params.originals,
            kept: params.kept,
            objects: self.columns.objects(),
            sigma: model.sigma,
            calibration: model.calibration,
            seed: params.seed,
            hash: model.search.hash.info(),
            measured: model.search.measured.clone(),
            thumbnail_side: params.thumbnail_side,
            provenance: params.provenance.clone(),
            sections,
        }
    }
}

/// Refuses more entries than the hash can number: the places of a random hash's ids are u32.
fn check_count(params: &IndexParams, entries: usize) -> Result<(), BuildError> {
    let tables = match params.hash {
        HashParams::Random(RandomParams::Fixed { t, .. }) => u64::from(t),
        HashParams::Random(RandomParams::Auto) | HashParams::Learned => 1,
    };
    u32::try_from(tables * entries as u64).map(|_| ()).map_err(|_| BuildError::TooMany("the entries"))
}

/// Writes the catalogue, and the header last of all; returns how many bytes the file has.
fn seal(out: &mut Sink, catalogue: &Catalogue, network: Option<&Network>) -> io::Result<u64> {
    let archive = wire::write(catalogue).map_err(io::Error::other)?;
    out.open()?;
    let header = Header {
        least_reader: wire::least_reader(catalogue, network),
        version: header::VERSION,
        file_length: out.len() + archive.len() as u64,
        catalogue_offset: out.len(),
        catalogue_length: archive.len() as u64,
        catalogue_hash: xxh3_64(&archive),
    };
    out.append(&archive)?;
    out.finish(&header.to_bytes())?;
    Ok(out.len())
}

/// Writes values in half their size.
fn append_halves(out: &mut Sink, values: &[u8]) -> io::Result<()> {
    let halves = bytemuck::cast_slice(values).iter().map(|&value| f16::from_f32(value));
    out.append(bytemuck::cast_slice(&halves.collect::<Vec<f16>>()))
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

#[cfg(test)]
mod tests;
