//! The file of a part: entries as they would go into an index, to the last bit.
//!
//! | bytes | |
//! |---|---|
//! | 8 | magic |
//! | 8 | length of the header |
//! | | the header: [`Header`] as JSON |
//! | 8 + 8 | held-out rows, and the number of their classes: as many, or 0 |
//! | 4 D each | the held-out descriptors, f32 |
//! | 2 each | their classes, u16 |
//! | 64 + ... each | entries: [`Fixed`], object, file, descriptor, thumbnail |
//! | 64 | zeros but for `end`: no entry |
//! | 8 + 8 | how many entries there are, and how many pictures that show no hand |
//! | 8 | xxh3 of all before |
//!
//! Little-endian, as an index is.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use anyhow::{Context as _, bail};
use bytemuck::{Pod, Zeroable};
use grasp_index::{AtomicFile, NewEntry};
use nalgebra::{Quaternion, UnitQuaternion};
use xxhash_rust::xxh3::Xxh3;

use super::header::Header;

/// No text, and broken by transfers that rewrite line ends.
const MAGIC: [u8; 8] = *b"\x89GPRT\r\n\x1a";
/// What is read or written at a time.
const PIECE: usize = 1 << 20;
/// Longer than any header, held-out rows or text that a shard writes; a damaged length shall not
/// fill the memory.
const MOST_BYTES: u64 = 1 << 30;

/// What every entry has.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Fixed {
    /// x, y, z, w.
    orientation: [f64; 4],
    source_hash: u64,
    view_deg: [f32; 3],
    file_len: u32,
    object_len: u16,
    class: u16,
    hand_shape: u16,
    stage: u8,
    /// 0 an entry, 1 an entry with a thumbnail, 2 the end.
    kind: u8,
}

const PLAIN: u8 = 0;
const WITH_THUMBNAIL: u8 = 1;
const END: u8 = 2;

/// Held-out descriptors, which the first part carries.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct HeldOutRows {
    pub(crate) descriptors: Vec<f32>,
    /// One a row, or none.
    pub(crate) classes: Vec<u16>,
}

impl From<(Vec<f32>, Vec<u16>)> for HeldOutRows {
    fn from((descriptors, classes): (Vec<f32>, Vec<u16>)) -> Self {
        Self { descriptors, classes }
    }
}

/// Whether the file at `path` begins as a part does.
pub(crate) fn is_part(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == MAGIC
}

/// A part that is being written.
pub(crate) struct PartWriter {
    out: BufWriter<AtomicFile>,
    hash: Xxh3,
    entries: u64,
    without_hand: u64,
}

impl PartWriter {
    pub(crate) fn new(file: AtomicFile, header: &Header, held_out: &HeldOutRows) -> anyhow::Result<Self> {
        let out = BufWriter::with_capacity(PIECE, file);
        let mut part = Self { out, hash: Xxh3::new(), entries: 0, without_hand: 0 };
        let json = header.to_json()?;
        part.write(&MAGIC)?;
        part.write(&(json.len() as u64).to_le_bytes())?;
        part.write(&json)?;
        let rows = held_out.descriptors.len() / header.params.descriptor.dim().max(1);
        part.write(&(rows as u64).to_le_bytes())?;
        part.write(&(held_out.classes.len() as u64).to_le_bytes())?;
        part.write(bytemuck::cast_slice(&held_out.descriptors))?;
        part.write(bytemuck::cast_slice(&held_out.classes))?;
        Ok(part)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hash.update(bytes);
        self.out.write_all(bytes)
    }

    /// Adds an entry, or counts a picture that shows no hand.
    pub(crate) fn push(&mut self, entry: Option<NewEntry>) -> anyhow::Result<()> {
        let Some(entry) = entry else {
            self.without_hand += 1;
            return Ok(());
        };
        let length = || format!("the names of {} are too long", entry.file);
        let [x, y, z, w] = entry.orientation.coords.into();
        let fixed = Fixed {
            orientation: [x, y, z, w],
            source_hash: entry.source_hash,
            view_deg: [entry.azimuth_deg, entry.elevation_deg, entry.roll_deg],
            file_len: u32::try_from(entry.file.len()).with_context(length)?,
            object_len: u16::try_from(entry.object.len()).with_context(length)?,
            class: entry.class,
            hand_shape: entry.hand_shape,
            stage: entry.stage,
            kind: if entry.thumbnail.is_some() { WITH_THUMBNAIL } else { PLAIN },
        };
        self.write(bytemuck::bytes_of(&fixed))?;
        self.write(entry.object.as_bytes())?;
        self.write(entry.file.as_bytes())?;
        self.write(bytemuck::cast_slice(&entry.descriptor))?;
        self.write(entry.thumbnail.as_deref().unwrap_or(&[]))?;
        self.entries += 1;
        Ok(())
    }

    /// Puts the part in its place and tells how many entries it has, and how many pictures show no
    /// hand.
    pub(crate) fn finish(mut self) -> anyhow::Result<(u64, u64)> {
        let counts = (self.entries, self.without_hand);
        self.write(bytemuck::bytes_of(&Fixed { kind: END, ..Fixed::zeroed() }))?;
        self.write(&counts.0.to_le_bytes())?;
        self.write(&counts.1.to_le_bytes())?;
        let hash = self.hash.digest();
        self.out.write_all(&hash.to_le_bytes())?;
        let file = self.out.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.commit()?;
        Ok(counts)
    }
}

/// A part that is being read.
pub(crate) struct PartReader {
    input: BufReader<File>,
    hash: Xxh3,
    header: Header,
    held_out: HeldOutRows,
    entries: u64,
}

impl PartReader {
    pub(crate) fn open(path: &Path) -> anyhow::Result<Self> {
        let mut input = BufReader::with_capacity(PIECE, File::open(path)?);
        let mut hash = Xxh3::new();
        if read(&mut input, &mut hash, 8)? != MAGIC {
            bail!("it is not a part of an index");
        }
        let length = read_u64(&mut input, &mut hash)?;
        let header = Header::from_json(&read(&mut input, &mut hash, length)?)?;
        let [rows, classes] = [read_u64(&mut input, &mut hash)?, read_u64(&mut input, &mut hash)?];
        let values = rows.saturating_mul(header.params.descriptor.dim() as u64);
        let descriptors = read(&mut input, &mut hash, values.saturating_mul(4))?;
        let classes = read(&mut input, &mut hash, classes.saturating_mul(2))?;
        let held_out = HeldOutRows {
            descriptors: bytemuck::pod_collect_to_vec(&descriptors),
            classes: bytemuck::pod_collect_to_vec(&classes),
        };
        Ok(Self { input, hash, header, held_out, entries: 0 })
    }

    pub(crate) fn header(&self) -> &Header {
        &self.header
    }

    /// What the part holds out; nothing after the first time.
    pub(crate) fn take_held_out(&mut self) -> HeldOutRows {
        std::mem::take(&mut self.held_out)
    }

    /// The next entry; after the last, once the whole part has proved sound, how many pictures show
    /// no hand.
    pub(crate) fn next(&mut self) -> anyhow::Result<Result<NewEntry, u64>> {
        let mut fixed = Fixed::zeroed();
        read_into(&mut self.input, &mut self.hash, bytemuck::bytes_of_mut(&mut fixed))?;
        if fixed.kind == END {
            return self.end().map(Err);
        }
        let object = self.text(fixed.object_len.into())?;
        let file = self.text(fixed.file_len.into())?;
        let params = &self.header.params;
        let mut descriptor = vec![0f32; params.descriptor.dim()];
        read_into(&mut self.input, &mut self.hash, bytemuck::cast_slice_mut(&mut descriptor))?;
        let pixels = u64::from(params.thumbnail_side).pow(2);
        let thumbnail = match fixed.kind {
            WITH_THUMBNAIL => Some(read(&mut self.input, &mut self.hash, pixels)?),
            _ => None,
        };
        self.entries += 1;
        let [x, y, z, w] = fixed.orientation;
        let [azimuth_deg, elevation_deg, roll_deg] = fixed.view_deg;
        Ok(Ok(NewEntry {
            class: fixed.class,
            stage: fixed.stage,
            hand_shape: fixed.hand_shape,
            object,
            file,
            azimuth_deg,
            elevation_deg,
            roll_deg,
            // As it was written: normalised once more, it could differ in the last bit. The index
            // checks its length.
            orientation: UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
            source_hash: fixed.source_hash,
            descriptor,
            thumbnail,
        }))
    }

    fn text(&mut self, length: u64) -> anyhow::Result<String> {
        String::from_utf8(read(&mut self.input, &mut self.hash, length)?).context("a name in it is not UTF-8")
    }

    fn end(&mut self) -> anyhow::Result<u64> {
        let [entries, without_hand] =
            [read_u64(&mut self.input, &mut self.hash)?, read_u64(&mut self.input, &mut self.hash)?];
        let expected = self.hash.digest();
        let found = read_u64(&mut self.input, &mut Xxh3::new())?;
        let is_the_end = self.input.read(&mut [0])? == 0;
        if found != expected || entries != self.entries || !is_the_end {
            bail!("it is damaged: its bytes do not match their hash");
        }
        Ok(without_hand)
    }
}

/// The numbers of entries and of pictures without a hand in the part at `path`, if it is whole and
/// has this header.
pub(super) fn holds(path: &Path, header: &Header) -> Option<(u64, u64)> {
    let mut part = PartReader::open(path).ok()?;
    if part.header() != header {
        return None;
    }
    loop {
        if let Err(without_hand) = part.next().ok()? {
            return Some((part.entries, without_hand));
        }
    }
}

fn read(input: &mut impl Read, hash: &mut Xxh3, length: u64) -> anyhow::Result<Vec<u8>> {
    if length > MOST_BYTES {
        bail!("it is damaged: one value of {length} bytes is not possible");
    }
    // Grows as bytes come, so that a damaged length costs nothing.
    let mut bytes = Vec::new();
    input.by_ref().take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 != length {
        bail!("it is truncated");
    }
    hash.update(&bytes);
    Ok(bytes)
}

fn read_into(input: &mut impl Read, hash: &mut Xxh3, bytes: &mut [u8]) -> anyhow::Result<()> {
    input.read_exact(bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => anyhow::anyhow!("it is truncated"),
        _ => error.into(),
    })?;
    hash.update(bytes);
    Ok(())
}

fn read_u64(input: &mut impl Read, hash: &mut Xxh3) -> anyhow::Result<u64> {
    let mut bytes = [0; 8];
    read_into(input, hash, &mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}
