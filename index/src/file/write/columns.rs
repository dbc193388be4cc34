//! What an index holds of each entry besides descriptor and thumbnail: small enough to be kept in
//! memory.

use crate::file::input::{BuildError, NewEntry};
use crate::file::kept::KeptFields;
use crate::file::pack;
use crate::file::sections::SectionKind;
use std::collections::HashMap;

/// One array for each thing that is known of an entry.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    entries: usize,
    pub(super) labels: Vec<u16>,
    pub(super) stages: Vec<u8>,
    pub(super) hand_shapes: Vec<u16>,
    pub(super) orientations: Vec<[i16; 4]>,
    pub(super) views: Vec<[u16; 3]>,
    pub(super) source_hashes: Vec<u64>,
    pub(super) files: TextTable,
    pub(super) objects: TextTable,
    pub(super) object_of: Vec<u16>,
    object_numbers: HashMap<String, u16>,
}

impl Columns {
    /// How many entries there are.
    pub(super) fn len(&self) -> usize {
        self.entries
    }

    /// Adds of an entry that was checked what is to be kept. Where there are too many names, no
    /// entry is added.
    pub(super) fn push(&mut self, entry: &NewEntry, kept: KeptFields) -> Result<(), BuildError> {
        if self.entries >= u32::MAX as usize {
            return Err(BuildError::TooMany("the entries"));
        }
        let object = if kept.labels { self.object(&entry.object)? } else { 0 };
        if kept.files {
            self.files.push(&entry.file).ok_or(BuildError::TooMany("the file names"))?;
        }
        if kept.labels {
            self.object_of.push(object);
            self.labels.push(entry.class);
            self.stages.push(entry.stage);
            self.hand_shapes.push(entry.hand_shape);
        }
        if kept.orientations {
            self.orientations.push(pack::pack_rotation(&entry.orientation));
        }
        if kept.views {
            let view = [entry.azimuth_deg, entry.elevation_deg, entry.roll_deg];
            self.views.push(view.map(pack::pack_degrees));
        }
        if kept.sources {
            self.source_hashes.push(entry.source_hash);
        }
        self.entries += 1;
        Ok(())
    }

    /// The number of an object.
    fn object(&mut self, name: &str) -> Result<u16, BuildError> {
        if let Some(&number) = self.object_numbers.get(name) {
            return Ok(number);
        }
        let too_many = || BuildError::TooMany("the objects' names");
        let number = u16::try_from(self.object_numbers.len()).map_err(|_| too_many())?;
        self.objects.push(name).ok_or_else(too_many)?;
        self.object_numbers.insert(name.to_owned(), number);
        Ok(number)
    }

    /// How many different objects there are.
    pub(super) fn objects(&self) -> u32 {
        self.object_numbers.len() as u32
    }

    /// The bytes of a section that holds a column; none for other sections.
    pub(super) fn section(&self, kind: SectionKind, kept: KeptFields) -> &[u8] {
        match kind {
            SectionKind::Labels => bytemuck::cast_slice(&self.labels),
            SectionKind::Stages => &self.stages,
            SectionKind::HandShapes => bytemuck::cast_slice(&self.hand_shapes),
            SectionKind::Orientations => bytemuck::cast_slice(&self.orientations),
            SectionKind::Views => bytemuck::cast_slice(&self.views),
            SectionKind::SourceHashes => bytemuck::cast_slice(&self.source_hashes),
            SectionKind::FileOffsets if kept.files => bytemuck::cast_slice(&self.files.offsets),
            SectionKind::FileText => self.files.text.as_bytes(),
            SectionKind::Objects => bytemuck::cast_slice(&self.object_of),
            SectionKind::ObjectOffsets if kept.labels => bytemuck::cast_slice(&self.objects.offsets),
            SectionKind::ObjectText => self.objects.text.as_bytes(),
            _ => &[],
        }
    }
}

/// Texts one after the other, and where each starts and ends.
#[derive(Clone, Debug)]
pub(super) struct TextTable {
    pub(super) offsets: Vec<u32>,
    pub(super) text: String,
}

impl Default for TextTable {
    fn default() -> Self {
        Self { offsets: vec![0], text: String::new() }
    }
}

impl TextTable {
    /// Adds a text; `None` where the table would outgrow its offsets.
    fn push(&mut self, text: &str) -> Option<()> {
        let end = u32::try_from(self.text.len() + text.len()).ok()?;
        self.text.push_str(text);
        self.offsets.push(end);
        Some(())
    }
}
