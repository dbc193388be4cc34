//! Building an index and writing it.

use super::atomic::{AtomicFile, WriteError};
use super::catalogue::{Catalogue, HashInfo};
use super::header::{self, Header};
use super::input::{BuildError, IndexParams, NewEntry, Phase, Summary};
use super::sections::{Section, SectionKind};
use super::{ALIGNMENT, align};
use crate::search::Rows;
use crate::search::random::{self, MAX_PLANES, RandomHash, RandomHyperplanes};
use crate::search::tables::Tables;
use crate::search::tune::{self, HashParams, Measured};
use crate::vote::{Sigma, measure_sigma};
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

/// Collects entries and writes them as an index. Entries keep the order in which they are added: the same entries in the
/// same order, with the same parameters, make the same bytes.
#[derive(Clone, Debug)]
pub struct IndexWriter {
    params: IndexParams,
    descriptors: Vec<f32>,
    labels: Vec<u16>,
    stages: Vec<u8>,
    hand_shapes: Vec<u16>,
    orientations: Vec<[f32; 4]>,
    views: Vec<[f32; 3]>,
    source_hashes: Vec<u64>,
    files: TextTable,
    objects: TextTable,
    object_of: Vec<u32>,
    object_numbers: HashMap<String, u32>,
    thumbnails: Vec<u8>,
}

/// Texts one after the other, and where each starts and ends.
#[derive(Clone, Debug)]
struct TextTable {
    offsets: Vec<u32>,
    text: String,
}

impl TextTable {
    fn new() -> Self {
        Self { offsets: vec![0], text: String::new() }
    }

    /// The number of the new text; `None` where the table would outgrow its offsets.
    fn push(&mut self, text: &str) -> Option<u32> {
        let end = u32::try_from(self.text.len() + text.len()).ok()?;
        self.text.push_str(text);
        self.offsets.push(end);
        u32::try_from(self.offsets.len() - 2).ok()
    }
}

impl IndexWriter {
    /// An index without entries.
    ///
    /// # Errors
    /// [`BuildError`], where the parameters are out of range.
    pub fn new(params: IndexParams) -> Result<Self, BuildError> {
        params.descriptor.validate()?;
        if params.classes.is_empty() || params.hand_shapes.is_empty() || params.stages.is_empty() {
            return Err(BuildError::Params(
                "an index needs at least one class, one hand shape and one stage",
            ));
        }
        if params.classes.len() > 1 << 16
            || params.hand_shapes.len() > 1 << 16
            || params.stages.len() > 1 << 8
        {
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
        Ok(Self {
            params,
            descriptors: Vec::new(),
            labels: Vec::new(),
            stages: Vec::new(),
            hand_shapes: Vec::new(),
            orientations: Vec::new(),
            views: Vec::new(),
            source_hashes: Vec::new(),
            files: TextTable::new(),
            objects: TextTable::new(),
            object_of: Vec::new(),
            object_numbers: HashMap::new(),
            thumbnails: Vec::new(),
        })
    }

    /// Adds to [`IndexParams::provenance`] what is known only when all entries are in.
    pub fn add_provenance(&mut self, provenance: impl IntoIterator<Item = (String, String)>) {
        self.params.provenance.extend(provenance);
    }

    /// How many entries have been added.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether none has been added.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// Adds an entry.
    ///
    /// # Errors
    /// [`BuildError::Entry`], where it does not fit the index's parameters; the index is then as it was.
    pub fn push(&mut self, entry: NewEntry) -> Result<(), BuildError> {
        if let Err(what) = self.check(&entry) {
            return Err(BuildError::Entry { file: entry.file, what });
        }
        let object = match self.object_numbers.get(&entry.object) {
            Some(&number) => number,
            None => {
                let number =
                    self.objects.push(&entry.object).ok_or(BuildError::TooMany("the objects' names"))?;
                self.object_numbers.insert(entry.object, number);
                number
            }
        };
        self.files.push(&entry.file).ok_or(BuildError::TooMany("the file names"))?;
        self.object_of.push(object);
        self.descriptors.extend(entry.descriptor);
        self.labels.push(entry.class);
        self.stages.push(entry.stage);
        self.hand_shapes.push(entry.hand_shape);
        self.orientations.push(entry.orientation.coords.map(|value| value as f32).into());
        self.views.push([entry.azimuth_deg, entry.elevation_deg, entry.roll_deg]);
        self.source_hashes.push(entry.source_hash);
        let pixels = (self.params.thumbnail_side as usize).pow(2);
        self.thumbnails.extend(entry.thumbnail.unwrap_or_else(|| vec![0; pixels]));
        Ok(())
    }

    fn check(&self, entry: &NewEntry) -> Result<(), String> {
        let params = &self.params;
        let dim = params.descriptor.dim();
        if entry.descriptor.len() != dim {
            return Err(format!(
                "its descriptor has {} values, the index's have {dim}",
                entry.descriptor.len()
            ));
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
        let pixels = (params.thumbnail_side as usize).pow(2);
        match &entry.thumbnail {
            Some(thumbnail) if thumbnail.len() != pixels => {
                Err(format!("its thumbnail has {} pixels, the index's have {pixels}", thumbnail.len()))
            }
            _ => Ok(()),
        }
    }

    /// Builds the tables and writes the index to `path`: the file there, if any, is replaced in one step, and is as it
    /// was where an error is returned. `progress` hears of every phase with a share from 0 to 1, and stops the
    /// work by breaking.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn finish(
        self,
        path: &Path,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Summary, BuildError> {
        self.finish_into(AtomicFile::create(path)?, progress)
    }

    /// As [`Self::finish`], into a file that was started (and locked) before the entries were collected.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn finish_into(
        self,
        mut file: AtomicFile,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Summary, BuildError> {
        let path = file.path().to_path_buf();
        let built = self.build(progress)?;
        let mut out = BufWriter::with_capacity(1 << 20, &mut file);
        let bytes = built.write(&mut out, progress).and_then(|bytes| out.flush().map(|()| bytes));
        let bytes = bytes.map_err(|error| match error.kind() {
            io::ErrorKind::Interrupted => BuildError::Stopped,
            _ => WriteError::Io { path, source: error }.into(),
        })?;
        drop(out);
        file.commit()?;
        Ok(built.summary(bytes))
    }

    /// Builds the index in memory: the bytes that [`Self::finish`] would write.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn finish_bytes(self) -> Result<Vec<u8>, BuildError> {
        let go_on = |_, _| ControlFlow::Continue(());
        let mut bytes = Vec::new();
        let built = self.build(&go_on)?;
        built.write(&mut bytes, &go_on).map_err(|source| WriteError::Io { path: "memory".into(), source })?;
        Ok(bytes)
    }

    fn build(self, progress: &dyn Fn(Phase, f64) -> ControlFlow<()>) -> Result<Built, BuildError> {
        if self.is_empty() {
            return Err(BuildError::Empty);
        }
        let step = |phase| match progress(phase, 0.0) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(BuildError::Stopped),
        };
        let dim = self.params.descriptor.dim();
        let rows = Rows { values: &self.descriptors, dim };
        let seed = self.params.seed;
        step(Phase::Sigma)?;
        let sigma = measure_sigma(&self.descriptors, dim, &self.labels, self.params.classes.len());
        step(Phase::Tune)?;
        let size = match self.params.hash {
            HashParams::Auto => tune::choose(rows, sigma.mean_distance, seed),
            HashParams::Fixed { k, t, buckets } => RandomHash { planes: k, tables: t, buckets, probes: 1 },
        };
        let ids = u64::from(size.tables) * rows.len() as u64;
        if u32::try_from(rows.len()).is_err() || u32::try_from(ids).is_err() {
            return Err(BuildError::TooMany("the entries"));
        }
        step(Phase::Tables)?;
        let (normals, offsets) = random::draw(rows, size.tables, size.planes, seed);
        let hash = RandomHyperplanes { size, dim, normals: &normals, offsets: &offsets };
        let tables = Tables::build(rows, size.tables, size.buckets, |row, table| hash.home(row, table));
        step(Phase::Measure)?;
        let measured = tune::measure(rows, &hash, &tables, size.probes, sigma.mean_distance, seed);
        Ok(Built { writer: self, sigma, hash: HashInfo::Random(size), normals, offsets, tables, measured })
    }
}

/// An index that is ready to be written.
struct Built {
    writer: IndexWriter,
    sigma: Sigma,
    hash: HashInfo,
    normals: Vec<f32>,
    offsets: Vec<f32>,
    tables: Tables,
    measured: Measured,
}

impl Built {
    fn section(&self, kind: SectionKind) -> &[u8] {
        let writer = &self.writer;
        match kind {
            SectionKind::Descriptors => bytemuck::cast_slice(&writer.descriptors),
            SectionKind::Labels => bytemuck::cast_slice(&writer.labels),
            SectionKind::Stages => &writer.stages,
            SectionKind::HandShapes => bytemuck::cast_slice(&writer.hand_shapes),
            SectionKind::Orientations => bytemuck::cast_slice(&writer.orientations),
            SectionKind::Views => bytemuck::cast_slice(&writer.views),
            SectionKind::SourceHashes => bytemuck::cast_slice(&writer.source_hashes),
            SectionKind::FileOffsets => bytemuck::cast_slice(&writer.files.offsets),
            SectionKind::FileText => writer.files.text.as_bytes(),
            SectionKind::Objects => bytemuck::cast_slice(&writer.object_of),
            SectionKind::ObjectOffsets => bytemuck::cast_slice(&writer.objects.offsets),
            SectionKind::ObjectText => writer.objects.text.as_bytes(),
            SectionKind::Thumbnails => &writer.thumbnails,
            SectionKind::PlaneNormals => bytemuck::cast_slice(&self.normals),
            SectionKind::PlaneOffsets => bytemuck::cast_slice(&self.offsets),
            SectionKind::BucketDirectory => bytemuck::cast_slice(&self.tables.directory),
            SectionKind::BucketIds => bytemuck::cast_slice(&self.tables.ids),
        }
    }

    /// The sections in the order of the file.
    fn sections(&self) -> io::Result<Vec<Section>> {
        let mut end = header::LENGTH as u64;
        let place = |kind: SectionKind| {
            let bytes = self.section(kind);
            let offset = aligned(end)?;
            end = offset + bytes.len() as u64;
            Ok(Section {
                kind,
                element: kind.element(),
                offset,
                length: bytes.len() as u64,
                xxh3: xxh3_64(bytes),
            })
        };
        SectionKind::ALL.into_iter().map(place).collect()
    }

    fn catalogue(&self) -> io::Result<Catalogue> {
        let params = &self.writer.params;
        Ok(Catalogue {
            entries: self.writer.len() as u64,
            dim: params.descriptor.dim() as u32,
            descriptor: params.descriptor,
            descriptor_fingerprint: params.descriptor.fingerprint(),
            classes: params.classes.clone(),
            hand_shapes: params.hand_shapes.clone(),
            stages: params.stages.clone(),
            objects: self.writer.objects.offsets.len() as u32 - 1,
            sigma: self.sigma,
            calibration: params.calibration,
            seed: params.seed,
            hash: self.hash,
            measured: self.measured,
            thumbnail_side: params.thumbnail_side,
            provenance: params.provenance.clone(),
            sections: self.sections()?,
        })
    }

    /// Writes the file and returns its length. Stopped by `progress`, it returns [`io::ErrorKind::Interrupted`].
    fn write(
        &self,
        out: &mut impl Write,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> io::Result<u64> {
        let catalogue = self.catalogue()?;
        let archive = rkyv::to_bytes::<rkyv::rancor::Error>(&catalogue).map_err(io::Error::other)?;
        let sections_end =
            catalogue.sections.last().map_or(header::LENGTH as u64, |last| last.offset + last.length);
        let catalogue_offset = aligned(sections_end)?;
        let file_length = catalogue_offset + archive.len() as u64;
        let header = Header {
            file_length,
            catalogue_offset,
            catalogue_length: archive.len() as u64,
            catalogue_hash: xxh3_64(&archive),
        };
        out.write_all(&header.to_bytes())?;
        let mut written = header::LENGTH as u64;
        for section in &catalogue.sections {
            if progress(Phase::Write, written as f64 / file_length as f64).is_break() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            pad(out, section.offset - written)?;
            out.write_all(self.section(section.kind))?;
            written = section.offset + section.length;
        }
        pad(out, catalogue_offset - written)?;
        out.write_all(&archive)?;
        Ok(file_length)
    }

    fn summary(&self, bytes: u64) -> Summary {
        Summary {
            entries: self.writer.len() as u64,
            bytes,
            sigma: self.sigma,
            hash: self.hash,
            measured: self.measured,
        }
    }
}

fn aligned(offset: u64) -> io::Result<u64> {
    align(offset).ok_or_else(|| io::Error::from(io::ErrorKind::FileTooLarge))
}

fn pad(out: &mut impl Write, bytes: u64) -> io::Result<()> {
    out.write_all(&[0; ALIGNMENT as usize][..bytes as usize])
}

#[cfg(test)]
mod tests;
