//! Landmarks in a file, as trackers of hands give them.

use std::path::Path;

use anyhow::Context as _;
use grasp_recognise::scene::Landmarks;

/// Reads the landmarks of a picture.
pub(super) fn read(path: &Path) -> anyhow::Result<Landmarks> {
    let about = || format!("cannot use the landmarks {}", path.display());
    let text = grasp_bounded::read_text(path).with_context(about)?;
    serde_json::from_str(&text).with_context(about)
}
