//! One encoded picture to pixels, by the `image` crate, within limits.

use std::io::Cursor;

use image::codecs::{
    bmp::BmpDecoder, gif::GifDecoder, jpeg::JpegDecoder, png::PngDecoder, pnm::PnmDecoder, webp::WebPDecoder,
};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, Limits};

use crate::limits::{MAX_BYTES_A_PIXEL, MAX_SIDE};
use crate::size::{check_size, max_bytes};
use crate::{DecodeError, DecodeWarning, Format, jpeg, png, webp};

/// A decoded picture.
#[derive(Clone, Debug)]
pub struct Decoded {
    /// The pixels as they are stored, before the orientation.
    pub image: DynamicImage,
    /// How they must be turned to be upright, as the EXIF data says.
    pub orientation: Orientation,
    /// What they were decoded from.
    pub format: Format,
    /// What is odd about the picture.
    pub warnings: Vec<DecodeWarning>,
}

/// Decodes a picture.
///
/// # Errors
/// Where the bytes are no picture that is read, are cut short, or would cost more than a picture
/// may.
pub fn decode(bytes: &[u8]) -> Result<Decoded, DecodeError> {
    let opened = Opened::new(bytes)?;
    let (width, height) = opened.decoder.dimensions();
    let most = max_bytes(opened.format, check_size(width, height)?);
    if bytes.len() as u64 > most {
        return Err(DecodeError::TooLong { most, width, height });
    }
    let Opened { format, decoder, exif, is_cut } = opened;
    let image = DynamicImage::from_decoder(decoder).map_err(|error| match explain(error) {
        // A decoder that ran out of a JPEG's data calls it damaged.
        DecodeError::Damaged(_) if is_cut => DecodeError::Truncated,
        other => other,
    })?;
    let warnings = if is_cut { vec![jpeg::missing(&image)?] } else { Vec::new() };
    let orientation = exif.and_then(Orientation::from_exif_chunk).unwrap_or(Orientation::NoTransforms);
    Ok(Decoded { image, orientation, format, warnings })
}

/// Width and height in pixels as the header says, before an EXIF orientation; nothing is decoded.
///
/// # Errors
/// Where the bytes are no picture that is read.
pub fn dimensions(bytes: &[u8]) -> Result<(u32, u32), DecodeError> {
    Ok(Opened::new(bytes)?.decoder.dimensions())
}

/// A picture whose header has been read.
struct Opened<'a> {
    format: Format,
    decoder: Box<dyn ImageDecoder + 'a>,
    exif: Option<&'a [u8]>,
    /// Whether it is a JPEG without its end marker.
    is_cut: bool,
}

impl<'a> Opened<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, DecodeError> {
        let format = Format::detect(bytes)?;
        let mut exif = None;
        let mut is_cut = false;
        let whole = Cursor::new(bytes);
        let decoder: Box<dyn ImageDecoder + 'a> = match format {
            Format::Png => {
                let (pieces, found) = png::essence(bytes);
                exif = found;
                // The decoder allocates a row before it can be asked for the size.
                if let Some((width, height)) = png::size(bytes) {
                    check_size(width, height)?;
                }
                let rows = limits(8 * MAX_BYTES_A_PIXEL * u64::from(MAX_SIDE));
                Box::new(PngDecoder::with_limits(pieces, rows).map_err(explain)?)
            }
            Format::Jpeg => {
                let essence = jpeg::essence(bytes)?;
                (exif, is_cut) = (essence.exif, essence.is_cut);
                Box::new(JpegDecoder::new(essence.pieces).map_err(|error| match explain(error) {
                    DecodeError::Damaged(_) if is_cut => DecodeError::Truncated,
                    other => other,
                })?)
            }
            Format::WebP => {
                let (pieces, found) = webp::essence(bytes)?;
                exif = found;
                Box::new(WebPDecoder::new(pieces).map_err(explain)?)
            }
            Format::Gif => {
                let mut decoder = GifDecoder::new(whole).map_err(explain)?;
                let (width, height) = decoder.dimensions();
                // A frame may be larger than the picture that it belongs to.
                decoder.set_limits(limits(4 * u64::from(width) * u64::from(height))).map_err(explain)?;
                Box::new(decoder)
            }
            Format::Bmp => Box::new(BmpDecoder::new(whole).map_err(explain)?),
            Format::Pnm => Box::new(PnmDecoder::new(whole).map_err(explain)?),
        };
        Ok(Self { format, decoder, exif, is_cut })
    }
}

/// At most `bytes` bytes besides the pixels.
fn limits(bytes: u64) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(bytes);
    limits
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
