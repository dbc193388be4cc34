//! Lines of text on pictures.

use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// How text is set; every character is as wide as any other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Font {
    pub(super) weight: FontWeight,
    pub(super) height: RasterHeight,
}

impl Font {
    /// For captions.
    pub(super) const BODY: Self = Self { weight: FontWeight::Regular, height: RasterHeight::Size16 };

    /// How wide a line is, in pixels.
    pub(super) fn width_of(self, line: &str) -> u32 {
        line.chars().count() as u32 * self.advance()
    }

    fn advance(self) -> u32 {
        get_raster_width(self.weight, self.height) as u32
    }
}

/// Writes a line with its top left corner at `(x, y)`; what falls outside the picture is left out.
pub(super) fn write(image: &mut RgbImage, (x, y): (u32, u32), font: Font, line: &str, colour: [u8; 3]) {
    let raster = |character| get_raster(character, font.weight, font.height);
    for (column, character) in (0u32..).zip(line.chars()) {
        let Some(glyph) = raster(character).or_else(|| raster('?')) else { continue };
        for (dy, row) in (0u32..).zip(glyph.rows()) {
            for (dx, &cover) in (0u32..).zip(row) {
                blend(image, (x + column * font.advance() + dx, y + dy), colour, cover);
            }
        }
    }
}

/// Covers a pixel by so much of 255 with a colour.
fn blend(image: &mut RgbImage, (x, y): (u32, u32), colour: [u8; 3], cover: u8) {
    let Some(Rgb(pixel)) = image.get_pixel_mut_checked(x, y) else { return };
    for (value, ink) in pixel.iter_mut().zip(colour) {
        let (cover, under, ink) = (u32::from(cover), u32::from(*value), u32::from(ink));
        *value = ((ink * cover + under * (255 - cover)) / 255) as u8;
    }
}
