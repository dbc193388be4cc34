//! Pictures as a command line names them.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use grasp_recognise::picture::{self, FORMATS, PicturesIn};
use grasp_terminal::text::{counted, shown};

/// The named files, with the pictures of a named folder in its place; what of these are of a format
/// that is not read is reported. One of several folders that holds no picture stays, as what cannot
/// be answered.
///
/// # Errors
/// Where a folder cannot be read, or the only one holds no picture.
pub(super) fn pictures(named: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut pictures = Vec::with_capacity(named.len());
    for path in named {
        if !path.is_dir() {
            pictures.push(path.clone());
            continue;
        }
        let PicturesIn { read: found, unread } = picture::pictures_in(path)
            .with_context(|| format!("cannot read the folder {}", path.display()))?;
        if let Some(first) = unread.first() {
            tracing::warn!(
                subject = path.display().to_string(),
                "{} of a format that is not read, such as {}: convert them to one of {FORMATS}",
                counted(unread.len(), ["picture is left out, being", "pictures are left out, being"]),
                shown(first)
            );
        }
        if found.is_empty() && named.len() > 1 {
            pictures.push(path.clone());
        } else if found.is_empty() {
            bail!(
                "the folder {} holds no picture, and folders in it are not searched: name pictures, or a folder that holds some",
                path.display()
            );
        }
        pictures.extend(found);
    }
    Ok(pictures)
}
