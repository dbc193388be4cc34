//! What an index holds of each entry besides descriptor and thumbnail: small enough to be kept in memory.

use crate::file::input::{BuildError, NewEntry};
use std::collections::HashMap;

/// One array for each thing that is known of an entry.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    pub(super) labels: Vec<u16>,
    pub(super) stages: Vec<u8>,
    pub(super) hand_shapes: Vec<u16>,
    pub(super) orientations: Vec<[f32; 4]>,
    pub(super) views: Vec<[f32; 3]>,
    pub(super) source_hashes: Vec<u64>,
    pub(super) files: TextTable,
    pub(super) objects: TextTable,
    pub(super) object_of: Vec<u32>,
    object_numbers: HashMap<String, u32>,
}

impl Columns {
    /// How many entries there are.
    pub(super) fn len(&self) -> usize {
        self.labels.len()
    }

    /// Adds an entry that was checked. The columns are as they were where there are too many names.
    pub(super) fn push(&mut self, entry: &NewEntry) -> Result<(), BuildError> {
        let object = match self.object_numbers.get(&entry.object) {
            Some(&number) => number,
            None => {
                let number =
                    self.objects.push(&entry.object).ok_or(BuildError::TooMany("the objects' names"))?;
                self.object_numbers.insert(entry.object.clone(), number);
                number
            }
        };
        self.files.push(&entry.file).ok_or(BuildError::TooMany("the file names"))?;
        self.object_of.push(object);
        self.labels.push(entry.class);
        self.stages.push(entry.stage);
        self.hand_shapes.push(entry.hand_shape);
        self.orientations.push(entry.orientation.coords.map(|value| value as f32).into());
        self.views.push([entry.azimuth_deg, entry.elevation_deg, entry.roll_deg]);
        self.source_hashes.push(entry.source_hash);
        Ok(())
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
    /// The number of the new text; `None` where the table would outgrow its offsets.
    fn push(&mut self, text: &str) -> Option<u32> {
        let end = u32::try_from(self.text.len() + text.len()).ok()?;
        self.text.push_str(text);
        self.offsets.push(end);
        u32::try_from(self.offsets.len() - 2).ok()
    }
}
