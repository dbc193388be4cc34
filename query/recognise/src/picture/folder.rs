//! The pictures of a folder.

use std::io;
use std::path::{Path, PathBuf};

use image::ImageFormat;

/// The endings of what phones, cameras and scanners write besides, none of which is read.
const UNREAD: [&str; 8] = ["heic", "heif", "hif", "avif", "tif", "tiff", "dng", "jxl"];

/// The pictures that lie in a folder itself, by the endings of their names and in the order of
/// their names, as a shell lists `FOLDER/*`: hidden files, other files and folders in it are left
/// out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PicturesIn {
    /// Those of formats that are read.
    pub read: Vec<PathBuf>,
    /// Those of formats that are not.
    pub unread: Vec<PathBuf>,
}

/// The pictures of a folder.
///
/// # Errors
/// Where the folder cannot be read.
pub fn pictures_in(folder: &Path) -> io::Result<PicturesIn> {
    let mut pictures = PicturesIn::default();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        let is_read = ImageFormat::from_path(&path).is_ok_and(|format| format.reading_enabled());
        let extension = path.extension().unwrap_or_default();
        let is_unread = UNREAD.iter().any(|ending| extension.eq_ignore_ascii_case(ending));
        if is_hidden || !(is_read || is_unread) || !path.is_file() {
            continue;
        }
        let kind = if is_read { &mut pictures.read } else { &mut pictures.unread };
        kind.push(path);
    }
    pictures.read.sort();
    pictures.unread.sort();
    Ok(pictures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_its_pictures_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.PNG", "a.jpg", "c.ppm", "e.HEIC", ".hidden.png", "labels.csv", "noending"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("d.png")).unwrap();
        let found = pictures_in(folder.path()).unwrap();
        assert_eq!(found.read, ["a.jpg", "b.PNG", "c.ppm"].map(|name| folder.path().join(name)));
        assert_eq!(found.unread, [folder.path().join("e.HEIC")]);
        assert!(pictures_in(&folder.path().join("none")).is_err());
    }
}
