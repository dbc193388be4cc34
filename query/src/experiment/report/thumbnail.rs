//! Pictures small enough to lie in a page.

use std::path::Path;

use anyhow::Context as _;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use grasp_recognise::picture;

/// The longest side, in pixels: twice as many as a card of the page is wide, for fine screens.
const SIDE: usize = 360;
/// Of the JPEG, 1..=100.
const QUALITY: u8 = 82;

/// A picture as a `data:` address, upright.
///
/// # Errors
/// Where the file cannot be read, or is no picture.
pub(super) fn address(path: &Path) -> anyhow::Result<String> {
    let small = picture::decode(&picture::read(path)?)?.picture.shrunk_to(SIDE);
    let mut bytes = Vec::new();
    let side = |pixels: usize| u32::try_from(pixels).context("no side is so long");
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode(
        small.rgb().as_flattened(),
        side(small.width())?,
        side(small.height())?,
        ExtendedColorType::Rgb8,
    )?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes)))
}
