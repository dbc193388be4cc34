//! One encoded picture (PNG, JPEG or PNM) to pixels, by the `image` crate, within limits.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};

use super::stream::is_cut_jpeg;
use super::{MAX_PIXELS, Picture};

/// The most bytes an encoded picture may have.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Why bytes are no picture that can be used.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// There are no bytes at all.
    #[error("the file is empty; a PNG, JPEG or PNM picture is needed")]
    Empty,
    /// The first bytes belong to no format that is read here.
    #[error("not a picture: its first bytes are neither PNG, JPEG nor PNM")]
    NotAnImage,
    /// The header asks for more pixels than are allowed; nothing was decoded.
    #[error("the header says {width} x {height} pixels; at most {} megapixels are read: shrink the picture first", MAX_PIXELS >> 20)]
    TooLarge {
        /// Pixels in a row, as the header says.
        width: u32,
        /// Rows, as the header says.
        height: u32,
    },
    /// The picture ends before its last pixel.
    #[error("truncated image: the file ends before the last pixel; copy it again")]
    Truncated,
    /// The picture is damaged or of a variety that is not read.
    #[error("damaged or unsupported image: {0}")]
    Damaged(String),
}

impl DecodeError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Read { .. } => "unreadable",
            Self::Empty | Self::NotAnImage => "not_an_image",
            Self::TooLarge { .. } => "too_large",
            Self::Truncated => "truncated",
            Self::Damaged(_) => "damaged",
        }
    }
}

/// The bytes of a file, refused early where it is too long to be a picture.
pub fn read(path: &Path) -> Result<Vec<u8>, DecodeError> {
    let cannot = |reason| DecodeError::Read { path: path.to_owned(), reason };
    let file = std::fs::File::open(path).map_err(cannot)?;
    let length = file.metadata().map_err(cannot)?.len();
    if length > MAX_FILE_BYTES {
        return Err(cannot(std::io::Error::other("more than 1 GiB, which no picture needs")));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // A device or a pipe has no honest length: bound what is read too.
    std::io::Read::read_to_end(&mut std::io::Read::take(file, MAX_FILE_BYTES), &mut bytes).map_err(cannot)?;
    Ok(bytes)
}

/// Decodes a colour picture, upright as its EXIF orientation says.
///
/// # Errors
/// Where the bytes are no picture, are cut short, or their header asks for more than [`MAX_PIXELS`].
pub fn decode(bytes: &[u8]) -> Result<Picture, DecodeError> {
    let decoded = dynamic(bytes)?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let pixels = if decoded.color().has_alpha() {
        // On black, as segmented pictures have it: what is transparent is no hand.
        let on_black = |value: u8, alpha: u8| (u16::from(value) * u16::from(alpha) / 255) as u8;
        let flat = |&image::Rgba([r, g, b, a]): &image::Rgba<u8>| [r, g, b].map(|value| on_black(value, a));
        decoded.into_rgba8().pixels().map(flat).collect()
    } else {
        decoded.into_rgb8().as_chunks().0.to_vec()
    };
    Picture::new(width, height, pixels).ok_or_else(|| DecodeError::Damaged("no pixels".into()))
}

/// Decodes a mask: width, height and one grey value (0..=255) a pixel.
///
/// # Errors
/// As [`decode`].
pub fn decode_grey(bytes: &[u8]) -> Result<(usize, usize, Vec<u8>), DecodeError> {
    let grey = dynamic(bytes)?.into_luma8();
    Ok((grey.width() as usize, grey.height() as usize, grey.into_raw()))
}

/// Decodes a depth picture: width, height and one 16-bit value a pixel, in the file's own unit.
///
/// # Errors
/// As [`decode`]; and where the file has 8 bits a channel, whose values mean no distance.
pub fn decode_grey16(bytes: &[u8]) -> Result<(usize, usize, Vec<u16>), DecodeError> {
    match dynamic(bytes)? {
        DynamicImage::ImageLuma16(grey) => {
            Ok((grey.width() as usize, grey.height() as usize, grey.into_raw()))
        }
        other => Err(DecodeError::Damaged(format!(
            "a depth picture has one channel of 16 bits, this one is {:?}",
            other.color()
        ))),
    }
}

/// Width and height in pixels as the header says, before an EXIF orientation; nothing is decoded.
///
/// # Errors
/// Where the bytes are no picture.
pub fn dimensions(bytes: &[u8]) -> Result<(u32, u32), DecodeError> {
    Ok(open(bytes)?.dimensions())
}

/// Reads the header.
fn open(bytes: &[u8]) -> Result<impl ImageDecoder + '_, DecodeError> {
    if bytes.is_empty() {
        return Err(DecodeError::Empty);
    }
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|_| DecodeError::NotAnImage)?;
    if reader.format().is_none() {
        return Err(DecodeError::NotAnImage);
    }
    // 16-bit RGBA, the widest pixel of the three formats, and as much again for the decoder's own tables.
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 16);
    reader.limits(limits);
    reader.into_decoder().map_err(explain)
}

fn dynamic(bytes: &[u8]) -> Result<DynamicImage, DecodeError> {
    let mut decoder = open(bytes)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(DecodeError::TooLarge { width, height });
    }
    if width == 0 || height == 0 {
        return Err(DecodeError::Damaged(format!("the header says {width} x {height} pixels")));
    }
    if is_cut_jpeg(bytes) {
        return Err(DecodeError::Truncated);
    }
    let orientation = decoder.orientation().map_err(explain)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(explain)?;
    image.apply_orientation(orientation);
    Ok(image)
}

fn explain(error: ImageError) -> DecodeError {
    let ended = |error: &std::io::Error| error.kind() == std::io::ErrorKind::UnexpectedEof;
    match &error {
        ImageError::IoError(source) if ended(source) => return DecodeError::Truncated,
        ImageError::Decoding(decoding) => {
            // Decoders wrap the reader's error at various depths, and some only say it in words.
            let mut cause = std::error::Error::source(decoding);
            while let Some(inner) = cause {
                if inner.downcast_ref::<std::io::Error>().is_some_and(ended) {
                    return DecodeError::Truncated;
                }
                cause = inner.source();
            }
            let words = decoding.to_string().to_ascii_lowercase();
            if ["not enough bytes", "unexpected end", "unexpected eof", "exhausted", "premature"]
                .iter()
                .any(|sign| words.contains(sign))
            {
                return DecodeError::Truncated;
            }
        }
        _ => {}
    }
    DecodeError::Damaged(error.to_string())
}

/// Whether an encoded picture is a JPEG, whose flat surfaces ring.
pub fn is_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF, 0xD8])
}
