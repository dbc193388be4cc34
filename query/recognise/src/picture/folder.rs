//! The pictures of a folder.

use std::io;
use std::path::{Path, PathBuf};

use image::ImageFormat;

/// The pictures that lie in `folder` itself, by the endings of their names and in the order of
/// their names, as a shell lists `FOLDER/*`: hidden files, other files and folders in it are left
/// out.
///
/// # Errors
/// Where the folder cannot be read.
pub fn pictures_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut pictures = Vec::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        let is_picture = ImageFormat::from_path(&path).is_ok_and(|format| format.reading_enabled());
        if is_picture && !is_hidden && path.is_file() {
            pictures.push(path);
        }
    }
    pictures.sort();
    Ok(pictures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_its_pictures_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.PNG", "a.jpg", "c.ppm", ".hidden.png", "labels.csv", "noending"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("d.png")).unwrap();
        let found = pictures_in(folder.path()).unwrap();
        assert_eq!(found, ["a.jpg", "b.PNG", "c.ppm"].map(|name| folder.path().join(name)));
        assert!(pictures_in(&folder.path().join("none")).is_err());
    }
}
