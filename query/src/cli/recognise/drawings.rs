//! `--explain OUT`: which file a picture's drawing is written to.

use std::collections::HashMap;
use std::path::{Path, PathBuf, is_separator};

use anyhow::{Context as _, bail};

use super::feed::is_stream;
use grasp_answer::explain::Format;

/// Where drawings go.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Drawings {
    /// The only picture's drawing.
    File(PathBuf),
    /// A file for each picture, named after it.
    Folder(PathBuf),
}

impl Drawings {
    /// What `out` means where this many pictures are given: a folder if it ends in a slash, is one
    /// already, or several pictures are given; otherwise a file, whose extension names its format.
    ///
    /// # Errors
    /// Where it could be meant either way.
    pub(super) fn new(out: &Path, pictures: usize) -> anyhow::Result<Self> {
        let (name, folder) = (out.display(), folder_like(out));
        let ends_in_slash = out.to_string_lossy().ends_with(is_separator);
        match Format::from_path(out) {
            _ if ends_in_slash || out.is_dir() => Ok(Self::Folder(out.to_owned())),
            Some(_) if pictures > 1 => {
                bail!(
                    "--explain {name} is one file, and {pictures} pictures are given: write {folder} for a folder"
                )
            }
            Some(_) => Ok(Self::File(out.to_owned())),
            None if pictures > 1 => Ok(Self::Folder(out.to_owned())),
            None => {
                let file = out.with_extension("png");
                bail!(
                    "--explain {name} is neither a .png nor a .jpg: write {} for a file, or {folder} for a folder",
                    file.display()
                )
            }
        }
    }

    /// Makes the folder.
    pub(super) fn prepare(&self) -> anyhow::Result<()> {
        let Self::Folder(folder) = self else { return Ok(()) };
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))
    }

    /// The files of named pictures' drawings.
    ///
    /// # Errors
    /// Where two pictures would have the same.
    pub(super) fn files(&self, pictures: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
        let folder = match self {
            Self::File(file) => return Ok(vec![file.clone()]),
            Self::Folder(folder) => folder,
        };
        let mut drawn: HashMap<String, &PathBuf> = HashMap::with_capacity(pictures.len());
        for picture in pictures.iter().filter(|picture| !is_stream(picture)) {
            let name = name_in_folder(&picture.display().to_string(), None);
            if let Some(other) = drawn.insert(name, picture) {
                if other == picture {
                    bail!("--explain would draw {} twice into one file: name it once", picture.display());
                }
                let (other, picture) = (other.display(), picture.display());
                bail!(
                    "--explain would draw {other} and {picture} into one file: recognise one after the other"
                );
            }
        }
        Ok(drawn.into_keys().map(|name| folder.join(name)).collect())
    }

    /// The file of a picture's drawing.
    ///
    /// # Errors
    /// Where the picture is one frame of several, and there is one file for all.
    pub(super) fn path(&self, picture: &str, frame: Option<u64>) -> anyhow::Result<PathBuf> {
        match (self, frame) {
            // A picture alone on standard input is frame 0.
            (Self::File(file), None | Some(0)) => Ok(file.clone()),
            (Self::File(file), Some(_)) => {
                let name = file.display();
                bail!(
                    "not drawn: --explain {name} is one file for several frames; write {name}/ for a folder"
                )
            }
            (Self::Folder(folder), _) => Ok(folder.join(name_in_folder(picture, frame))),
        }
    }
}

/// How a folder would be named by one who wrote `out`.
fn folder_like(out: &Path) -> String {
    format!("{}/", out.with_extension("").display())
}

/// The file name of a drawing in a folder: the picture's path with its separators flattened, so
/// that `a/1.jpg` and `b/1.jpg` have two.
fn name_in_folder(picture: &str, frame: Option<u64>) -> String {
    let flat = picture.trim_start_matches(['.', '/', '\\']).replace(['/', '\\', ':'], "_");
    match frame {
        Some(frame) if flat != "-" && is_stream(Path::new(picture)) => format!("{flat}-{frame:06}.png"),
        Some(frame) => format!("frame-{frame:06}.png"),
        None if flat == "-" || flat.is_empty() => "stdin.png".into(),
        None => format!("{flat}.png"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_file_or_a_folder_and_never_a_guess() {
        let of =
            |out: &str, pictures| Drawings::new(Path::new(out), pictures).map_err(|error| error.to_string());
        for file in ["why.png", "why.jpg", "a.b/why.JPEG"] {
            assert_eq!(of(file, 1), Ok(Drawings::File(file.into())));
            assert!(of(file, 2).unwrap_err().contains("why/ for a folder"), "{file}");
        }
        for folder in ["why/", "why.png/", "."] {
            assert_eq!(of(folder, 1), Ok(Drawings::Folder(folder.into())));
        }
        assert_eq!(of("why", 2), Ok(Drawings::Folder("why".into())));
        for unclear in ["why", "why.pdf"] {
            assert!(of(unclear, 1).unwrap_err().contains("write why.png for a file, or why/"), "{unclear}");
        }
    }

    #[test]
    fn drawings_of_files_of_the_same_name_differ() {
        assert_eq!(name_in_folder("a/1.jpg", None), "a_1.jpg.png");
        assert_ne!(name_in_folder("a/1.jpg", None), name_in_folder("b/1.jpg", None));
        assert_eq!(name_in_folder("-", Some(12)), "frame-000012.png");
        assert_eq!(name_in_folder("a/seen.mjpg", Some(12)), "a_seen.mjpg-000012.png");
        assert_eq!(name_in_folder("-", None), "stdin.png");
    }

    #[test]
    fn two_pictures_are_not_drawn_into_one_file() {
        let drawings = Drawings::Folder("why".into());
        let files = |names: &[&str]| {
            let pictures: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            let mut files = drawings.files(&pictures).map_err(|error| error.to_string())?;
            files.sort();
            Ok::<_, String>(files)
        };
        let why = |name: &str| Path::new("why").join(name);
        assert_eq!(files(&["a/1.jpg", "b/1.jpg", "-"]), Ok(vec![why("a_1.jpg.png"), why("b_1.jpg.png")]));
        for [one, other] in [["a/b.jpg", "a_b.jpg"], ["../a/1.jpg", "a/1.jpg"], ["a.jpg", "a.jpg"]] {
            let error = files(&[one, other]).unwrap_err();
            assert!(error.contains(one) && error.contains(other), "{error}");
        }
        let one = Drawings::File("why.png".into()).files(&["a.jpg".into()]).unwrap();
        assert_eq!(one, [PathBuf::from("why.png")]);
    }

    #[test]
    fn one_file_is_not_drawn_over_by_frame_after_frame() {
        let drawings = Drawings::File("why.png".into());
        assert!(drawings.path("-", Some(0)).is_ok(), "it may be the only one");
        assert!(drawings.path("-", Some(1)).is_err());
    }
}
