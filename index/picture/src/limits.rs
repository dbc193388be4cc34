//! How large a picture may be, encoded and decoded.

use crate::{DecodeError, Format};

/// The most pixels a picture may have: the largest phone cameras (108 megapixels) pass, a forged
/// header does not.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The most pixels a side may have: what JPEG and GIF can say at all. Decoders hold several rows at
/// a time, so that a picture of a single row would cost several times its pixels.
pub const MAX_SIDE: u32 = 65_535;

/// The most encoded bytes that a pixel may take where pixels may be stored as they are: 16-bit
/// RGBA, the widest.
pub const MAX_BYTES_A_PIXEL: u64 = 8;

/// The most encoded bytes that a pixel may take where it always is compressed. A JPEG of noise at
/// the highest quality has three.
pub const MAX_COMPRESSED_BYTES_A_PIXEL: u64 = 4;

/// The bytes that an encoded picture may have besides: headers, colour profile, text, thumbnails.
pub const MAX_OVERHEAD: u64 = 32 << 20;

/// The most bytes that an encoded picture of so many pixels may have.
pub(crate) fn max_bytes(format: Format, pixels: u64) -> u64 {
    let a_pixel = match format {
        Format::Png | Format::Bmp | Format::Pnm => MAX_BYTES_A_PIXEL,
        Format::Jpeg | Format::WebP | Format::Gif => MAX_COMPRESSED_BYTES_A_PIXEL,
    };
    pixels.saturating_mul(a_pixel).saturating_add(MAX_OVERHEAD)
}

/// Checks what a header says against the limits, and returns the number of pixels.
pub(crate) fn check_size(width: u32, height: u32) -> Result<u64, DecodeError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS || width > MAX_SIDE || height > MAX_SIDE {
        return Err(DecodeError::TooLarge { width, height });
    }
    if pixels == 0 {
        return Err(DecodeError::Damaged(format!("the header says {width} x {height} pixels")));
    }
    Ok(pixels)
}
