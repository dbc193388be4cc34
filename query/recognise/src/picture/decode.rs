//! A decoded picture as what recognition works on: colours on black, a mask's grey, or depths.

use grasp_picture::{DecodeError, DecodeWarning, Format};
use image::{DynamicImage, GenericImageView as _, Rgb, RgbImage, Rgba};

use super::rgb::Picture;

/// A colour picture, upright.
#[derive(Clone, Debug)]
pub struct Decoded {
    /// The pixels.
    pub picture: Picture,
    /// Whether it was a JPEG, whose flat surfaces ring.
    pub is_jpeg: bool,
    /// What is odd about it.
    pub warnings: Vec<DecodeWarning>,
}

/// Decodes a colour picture, upright as its EXIF orientation says. What is transparent is black.
///
/// # Errors
/// Where the bytes are no picture, are cut short, or would cost more than a picture may.
pub fn decode(bytes: &[u8]) -> Result<Decoded, DecodeError> {
    let decoded = grasp_picture::decode(bytes)?;
    let mut image = on_black(decoded.image);
    // At a byte a channel: turning needs the picture twice.
    image.apply_orientation(decoded.orientation);
    let (width, height) = (image.width() as usize, image.height() as usize);
    // The decoder's own memory, unless it is not of whole pixels.
    let pixels = bytemuck::allocation::try_cast_vec(image.into_rgb8().into_raw())
        .unwrap_or_else(|(_, bytes)| bytes.as_chunks().0.to_vec());
    let picture =
        Picture::new(width, height, pixels).ok_or_else(|| DecodeError::Damaged("no pixels".into()))?;
    Ok(Decoded { picture, is_jpeg: decoded.format == Format::Jpeg, warnings: decoded.warnings })
}

/// As 8 bits a channel without transparency, as segmented pictures have it: what is transparent is
/// no hand.
fn on_black(image: DynamicImage) -> DynamicImage {
    if !image.color().has_alpha() {
        return image.into_rgb8().into();
    }
    let flat = |Rgba([r, g, b, a]): Rgba<u8>| {
        Rgb([r, g, b].map(|value| (u16::from(value) * u16::from(a) / 255) as u8))
    };
    // Pixel by pixel: 16-bit RGBA is half of what a picture may cost already.
    let (width, height) = image.dimensions();
    match image {
        DynamicImage::ImageRgba8(image) => {
            RgbImage::from_fn(width, height, |x, y| flat(*image.get_pixel(x, y)))
        }
        other => RgbImage::from_fn(width, height, |x, y| flat(other.get_pixel(x, y))),
    }
    .into()
}

/// Decodes a mask: width, height and one grey value (0..=255) a pixel; what is transparent is
/// black, as in [`decode`].
///
/// # Errors
/// As [`decode`]; and where anything is missing, because a mask has nobody to warn.
pub fn decode_grey(bytes: &[u8]) -> Result<(usize, usize, Vec<u8>), DecodeError> {
    let decoded = whole(bytes)?;
    let opaque = if decoded.image.color().has_alpha() { on_black(decoded.image) } else { decoded.image };
    let mut image = DynamicImage::from(opaque.into_luma8());
    image.apply_orientation(decoded.orientation);
    let grey = image.into_luma8();
    Ok((grey.width() as usize, grey.height() as usize, grey.into_raw()))
}

/// Decodes a depth picture: width, height and one 16-bit value a pixel, in the file's own unit.
///
/// # Errors
/// As [`decode_grey`]; and where the file has 8 bits a channel, whose values mean no distance.
pub fn decode_grey16(bytes: &[u8]) -> Result<(usize, usize, Vec<u16>), DecodeError> {
    let decoded = whole(bytes)?;
    let mut image = decoded.image;
    image.apply_orientation(decoded.orientation);
    match image {
        DynamicImage::ImageLuma16(grey) => {
            Ok((grey.width() as usize, grey.height() as usize, grey.into_raw()))
        }
        other => {
            let colour = other.color();
            let (channels, bits) = (colour.channel_count(), colour.bits_per_pixel());
            Err(DecodeError::Damaged(format!(
                "a depth picture has 1 channel of 16 bits, this one {channels} of {}",
                bits / u16::from(channels)
            )))
        }
    }
}

fn whole(bytes: &[u8]) -> Result<grasp_picture::Decoded, DecodeError> {
    let decoded = grasp_picture::decode(bytes)?;
    if decoded.warnings.is_empty() { Ok(decoded) } else { Err(DecodeError::Truncated) }
}
