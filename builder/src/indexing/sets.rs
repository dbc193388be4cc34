//! Entries read from render sets on disk.

use std::fs;
use std::io::Read as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_index::Describer;
use grasp_index::{ClassInfo, NewEntry};
use grasp_renders::GraspSet;
use grasp_renders::render_set::{MANIFEST, Manifest, ManifestError, ManifestRow};
use rayon::prelude::*;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::described::{Described, Grey, Take, complete};
use super::known::Known;
use super::names::Names;
use super::recipe::Recipe;

/// Pictures that are read and held at a time.
const PICTURES_AT_ONCE: usize = 1024;

/// The longest side of a render that is accepted, in pixels: far beyond any use, far below what
/// would fill the memory.
const MOST_PIXELS_A_SIDE: u32 = 8192;

/// The most bytes that the file of a render may have.
const MOST_BYTES: u64 = 256 << 20;

/// A render set whose manifest has been read and checked.
#[derive(Debug)]
pub struct RenderSet {
    name: String,
    manifest: Manifest,
    manifest_hash: u64,
}

/// Why a render set cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SetError {
    /// The folder has no manifest, or cannot be read.
    #[error(
        "{path} cannot be read; a render set is a folder with a {MANIFEST}, as `grasp-builder render` writes it"
    )]
    NoManifest {
        /// The manifest that was looked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The manifest is wrong.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
}

impl RenderSet {
    /// Reads the manifest of the set in `folder`, whose classes are those of `grasps`. The pictures
    /// are looked for, but not read yet.
    ///
    /// # Errors
    /// [`SetError`], with the line of the manifest where there is one to name.
    pub fn open(folder: &Path, grasps: &GraspSet) -> Result<Self, SetError> {
        let path = folder.join(MANIFEST);
        let read = fs::read(&path);
        let bytes = read.map_err(|source| SetError::NoManifest { path: path.clone(), source })?;
        // Of the same bytes as the hash.
        let manifest = Manifest::parse(&bytes, path, grasps)?;
        // `.` and `..` have no name of their own.
        let absolute = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        let name =
            absolute.file_name().map_or_else(|| "renders".into(), |name| name.to_string_lossy().into_owned());
        Ok(Self { name, manifest, manifest_hash: xxh3_64(&bytes) })
    }

    /// The name of the set's folder; the files of its entries begin with it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many pictures it lists.
    #[must_use]
    pub fn len(&self) -> usize {
        self.manifest.rows.len()
    }

    /// Whether it lists none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.manifest.rows.is_empty()
    }

    /// A hash of the manifest's bytes.
    #[must_use]
    pub fn manifest_hash(&self) -> u64 {
        self.manifest_hash
    }

    /// The hand shape of each picture.
    pub(crate) fn hand_shapes(&self) -> impl Iterator<Item = &str> {
        self.manifest.rows.iter().map(|row| row.hand_shape.as_str())
    }

    fn rows(&self) -> impl Iterator<Item = (&Self, &ManifestRow)> {
        self.manifest.rows.iter().map(move |row| (self, row))
    }
}

/// The names that the sets' rows use: classes by number, the others in the order of their first
/// use.
pub(super) fn names(sets: &[RenderSet]) -> anyhow::Result<Names> {
    let mut names = Names::default();
    for (_, row) in sets.iter().flat_map(RenderSet::rows) {
        names.add_hand_shape(&row.hand_shape)?;
        names.add_stage(row.stage.name())?;
        if !names.classes.iter().any(|class| class.name == row.grasp) {
            names.classes.push(ClassInfo { name: row.grasp.clone(), cutkosky: row.cutkosky });
        }
    }
    names.sort_classes();
    Ok(names)
}

/// Describes some of the sets' pictures and hands the results to `take` in order.
pub(super) fn describe(
    sets: &[RenderSet],
    names: &Names,
    recipe: &Recipe,
    known: &Known,
    pieces: Range<usize>,
    take: Take<'_>,
) -> anyhow::Result<()> {
    let rows: Vec<(&RenderSet, &ManifestRow)> = sets.iter().flat_map(RenderSet::rows).collect();
    for batch in rows.get(pieces).unwrap_or(&[]).chunks(PICTURES_AT_ONCE) {
        take(
            batch
                .par_iter()
                .map_init(
                    || recipe.descriptor.describer(),
                    |describer, (set, row)| entry(set, row, names, recipe, describer, known),
                )
                .collect::<Result<_, _>>()?,
        )?;
    }
    Ok(())
}

/// A number for some of the sets' pictures and what the manifests say of them.
pub(super) fn digest(sets: &[RenderSet], pieces: Range<usize>) -> anyhow::Result<u64> {
    let mut hash = Xxh3::new();
    sets.iter().for_each(|set| hash.update(&set.manifest_hash.to_le_bytes()));
    let rows: Vec<(&RenderSet, &ManifestRow)> = sets.iter().flat_map(RenderSet::rows).collect();
    for (set, row) in rows.get(pieces).unwrap_or(&[]) {
        let path = set.manifest.folder.join(&row.file);
        let bytes = read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        hash.update(&xxh3_64(&bytes).to_le_bytes());
    }
    Ok(hash.digest())
}

fn entry(
    set: &RenderSet,
    row: &ManifestRow,
    names: &Names,
    recipe: &Recipe,
    describer: &mut Describer,
    known: &Known,
) -> anyhow::Result<Described> {
    let path = set.manifest.folder.join(&row.file);
    let bytes = read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let entry = NewEntry {
        class: names.class(&row.grasp)?,
        stage: names.stage(row.stage.name())?,
        hand_shape: names.hand_shape(&row.hand_shape)?,
        object: row.object.clone(),
        file: format!("{}/{}", set.name, row.file),
        azimuth_deg: row.view.azimuth_deg as f32,
        elevation_deg: row.view.elevation_deg as f32,
        roll_deg: row.view.roll_deg as f32,
        orientation: row.camera_from_hand,
        source_hash: source_hash(&bytes, row),
        ..NewEntry::default()
    };
    complete(entry, recipe, describer, known, || {
        decode(&bytes).with_context(|| format!("cannot use {}", path.display()))
    })
}

/// What a descriptor and its turn follow from: the picture, and the roll that its turn is added to.
fn source_hash(picture: &[u8], row: &ManifestRow) -> u64 {
    let mut hash = Xxh3::new();
    hash.update(picture);
    hash.update(&row.view.roll_deg.to_bits().to_le_bytes());
    hash.digest()
}

/// Reads a picture file, unless it is larger than any render can be.
fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_BYTES {
        bail!("it is larger than {} MB", MOST_BYTES / 1_000_000);
    }
    Ok(bytes)
}

/// Decodes a picture of any supported format into grey values.
fn decode(bytes: &[u8]) -> anyhow::Result<Grey> {
    let (width, height) = grasp_picture::dimensions(bytes)?;
    if width > MOST_PIXELS_A_SIDE || height > MOST_PIXELS_A_SIDE {
        bail!("its header says {width} x {height} pixels; a render has at most {MOST_PIXELS_A_SIDE} a side");
    }
    let decoded = grasp_picture::decode(bytes)?;
    // An index is for long: what is missing of a render would stay wrong in it.
    if let Some(warning) = decoded.warnings.first() {
        bail!("{warning}");
    }
    // On black: what is transparent is no hand.
    let picture = decoded.image.into_luma_alpha8();
    let on_black =
        |&image::LumaA([grey, alpha]): &image::LumaA<u8>| (u16::from(grey) * u16::from(alpha) / 255) as u8;
    let pixels = picture.pixels().map(on_black).collect();
    Ok(Grey { width: picture.width() as usize, height: picture.height() as usize, pixels })
}
