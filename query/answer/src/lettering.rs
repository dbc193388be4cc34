//! Lines of text on pictures.

use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// How text is set; every character is as wide as any other.
#[derive(Clone, Copy, Debug)]
pub struct Font {
    weight: FontWeight,
    height: RasterHeight,
}

impl Font {
    /// For captions and running text.
    pub const BODY: Self = Self { weight: FontWeight::Regular, height: RasterHeight::Size16 };
    /// For what stands out of it.
    pub const STRONG: Self = Self { weight: FontWeight::Bold, height: RasterHeight::Size16 };
    /// For headlines.
    pub const HEADLINE: Self = Self { weight: FontWeight::Bold, height: RasterHeight::Size24 };

    /// Pixels from one character to the next.
    fn advance(self) -> u32 {
        get_raster_width(self.weight, self.height) as u32
    }

    /// Characters that fit into `width` pixels.
    pub(crate) fn room(self, width: u32) -> usize {
        (width / self.advance()) as usize
    }

    /// How wide a line is, in pixels.
    pub fn width_of(self, line: &str) -> u32 {
        line.chars().count() as u32 * self.advance()
    }

    /// Breaks text into lines that are at most `width` pixels wide. A word that is wider has a line
    /// to itself.
    pub(crate) fn wrap(self, text: &str, width: u32) -> Vec<String> {
        let room = self.room(width);
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if line.chars().count() + 1 + word.chars().count() <= room => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }
}

/// Writes a line with its top left corner at `(x, y)`, in pixels; what falls outside the picture is
/// left out.
pub fn write(image: &mut RgbImage, (x, y): (u32, u32), font: Font, line: &str, colour: [u8; 3]) {
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
pub(crate) fn blend(image: &mut RgbImage, (x, y): (u32, u32), colour: [u8; 3], cover: u8) {
    let Some(Rgb(pixel)) = image.get_pixel_mut_checked(x, y) else { return };
    for (value, ink) in pixel.iter_mut().zip(colour) {
        let (cover, under, ink) = (u32::from(cover), u32::from(*value), u32::from(ink));
        *value = ((ink * cover + under * (255 - cover)) / 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_the_signs_that_the_sheet_needs() {
        for font in [Font::BODY, Font::STRONG, Font::HEADLINE] {
            for sign in ['°', '±', '×', '%', 'ä'] {
                assert!(get_raster(sign, font.weight, font.height).is_some(), "{sign} in {font:?}");
            }
        }
    }

    #[test]
    fn lines_are_broken_between_words() {
        let width = Font::BODY.width_of("the thumb");
        assert_eq!(
            Font::BODY.wrap("the thumb side, unbreakable", width),
            ["the thumb", "side,", "unbreakable"]
        );
        assert!(Font::BODY.wrap("", width).is_empty());
    }
}
