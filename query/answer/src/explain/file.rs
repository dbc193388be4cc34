//! A drawing as a file: what a name's extension says it is, it is.

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use grasp_index::{AtomicFile, WriteError};
use image::codecs::jpeg::JpegEncoder;
use image::{ImageError, RgbImage};

/// What a drawing is encoded as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Lossless.
    Png,
    /// Smaller, and read by everything.
    Jpeg,
}

/// JPEG's quality: text stays sharp.
const JPEG_QUALITY: u8 = 92;

/// Why a drawing was not written.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// The name says no format.
    #[error("{} says no format to draw in: end the name in .png or .jpg", .0.display())]
    Format(PathBuf),
    /// It cannot be encoded.
    #[error("the drawing cannot be encoded")]
    Encode(#[from] ImageError),
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The disk refused some of it.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Format {
    /// The format that a path's extension names: `.png`, `.jpg` or `.jpeg`, in any case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let is = |name: &str| extension.eq_ignore_ascii_case(name);
        match () {
            () if is("png") => Some(Self::Png),
            () if is("jpg") || is("jpeg") => Some(Self::Jpeg),
            () => None,
        }
    }

    /// The bytes of a drawing.
    ///
    /// # Errors
    /// Where it cannot be encoded.
    pub fn encode(self, image: &RgbImage) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        match self {
            Self::Png => image.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png)?,
            Self::Jpeg => {
                image.write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY))?
            }
        }
        Ok(bytes)
    }
}

/// Writes a drawing in the format that the path's extension names: the whole of it, or nothing.
///
/// # Errors
/// [`SaveError`]: where the extension names no format, or the file cannot be written.
pub fn save(image: &RgbImage, path: &Path) -> Result<(), SaveError> {
    let format = Format::from_path(path).ok_or_else(|| SaveError::Format(path.to_owned()))?;
    let bytes = format.encode(image)?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&bytes)?;
    file.commit()?;
    Ok(())
}
