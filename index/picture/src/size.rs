//! Whether a picture is of a size that is read.

use crate::limits::{MAX_BYTES_A_PIXEL, MAX_COMPRESSED_BYTES_A_PIXEL, MAX_OVERHEAD, MAX_PIXELS, MAX_SIDE};
use crate::{DecodeError, Format};

/// The most bytes that an encoded picture of `pixels` pixels may have.
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
