//! What an index of a preset is by default, where its options do not say otherwise.

use grasp_renders::Preset;

use crate::descriptor::LEARNED;
use crate::indexing::THUMBNAIL_SIDE;

/// Names as in the options of `build`.
#[derive(Clone, Copy, Debug)]
pub(super) struct PresetDefaults {
    /// How hand images are described.
    pub(super) descriptor: &'static str,
    /// How exact distances are kept.
    pub(super) originals: &'static str,
    /// Side of the thumbnails in pixels.
    pub(super) thumbnail_side: u32,
}

impl PresetDefaults {
    /// Views with any roll are turned upright before they are described, and many views are kept
    /// small.
    pub(super) fn of_preset(preset: Preset) -> Self {
        match preset {
            Preset::Paper => Self { descriptor: "default", originals: "f32", thumbnail_side: THUMBNAIL_SIDE },
            Preset::Standard | Preset::Wide => {
                Self { descriptor: LEARNED, originals: "f16", thumbnail_side: 20 }
            }
        }
    }
}
