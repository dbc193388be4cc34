//! How large a picture may be, encoded and decoded.

use crate::DecodeError;

/// The most pixels a picture may have: the largest phone cameras (108 megapixels) pass, a forged header does not.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The most pixels a side may have: what JPEG and GIF can say at all. Decoders hold several rows at a time, so that a
/// picture of a single row would cost several times its pixels.
pub const MAX_SIDE: u32 = 65_535;

/// The most encoded bytes that a pixel may take: 16-bit RGBA, the widest pixel of the formats, not compressed.
pub const MAX_BYTES_A_PIXEL: u64 = 8;

/// The bytes that an encoded picture may have besides: headers, colour profile, text, thumbnails.
pub const MAX_OVERHEAD: u64 = 32 << 20;

/// The most bytes that an encoded picture of so many pixels may have.
pub(crate) fn max_bytes(pixels: u64) -> u64 {
    pixels.saturating_mul(MAX_BYTES_A_PIXEL).saturating_add(MAX_OVERHEAD)
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
