//! A picture to draw tiles, lines of text and pictures on.

use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Pixels from one line of text to the next.
pub(super) const LINE: u32 = 18;
const FONT: (FontWeight, RasterHeight) = (FontWeight::Regular, RasterHeight::Size16);

/// Colours of the drawing.
pub(super) mod colour {
    pub(in crate::explain) const PAPER: [u8; 3] = [24, 24, 28];
    pub(in crate::explain) const INK: [u8; 3] = [236, 236, 236];
    pub(in crate::explain) const FAINT: [u8; 3] = [150, 150, 156];
    pub(in crate::explain) const FRAME: [u8; 3] = [64, 64, 72];
    pub(in crate::explain) const GOOD: [u8; 3] = [110, 210, 130];
    pub(in crate::explain) const OTHER: [u8; 3] = [230, 150, 100];
}

/// A drawing; all that falls outside is left out.
#[derive(Debug)]
pub(super) struct Canvas {
    image: RgbImage,
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32) -> Self {
        Self { image: RgbImage::from_pixel(width, height, Rgb(colour::PAPER)) }
    }

    pub(super) fn into_image(self) -> RgbImage {
        self.image
    }

    pub(super) fn pixel(&mut self, x: u32, y: u32, colour: [u8; 3]) {
        if let Some(pixel) = self.image.get_pixel_mut_checked(x, y) {
            *pixel = Rgb(colour);
        }
    }

    pub(super) fn fill(&mut self, (x, y): (u32, u32), (width, height): (u32, u32), colour: [u8; 3]) {
        for dy in 0..height {
            for dx in 0..width {
                self.pixel(x + dx, y + dy, colour);
            }
        }
    }

    /// Writes `text` with its top left corner at `(x, y)`, cut to `width` pixels.
    pub(super) fn text(&mut self, (x, y): (u32, u32), width: u32, text: &str, colour: [u8; 3]) {
        let advance = get_raster_width(FONT.0, FONT.1) as u32;
        let room = (width / advance) as usize;
        let shown: String = if text.chars().count() > room {
            // The end of a path says more than its beginning.
            let skip = text.chars().count() - room.saturating_sub(1);
            std::iter::once('~').chain(text.chars().skip(skip)).collect()
        } else {
            text.to_owned()
        };
        for (column, character) in (0u32..).zip(shown.chars()) {
            let glyph = get_raster(character, FONT.0, FONT.1).or_else(|| get_raster('?', FONT.0, FONT.1));
            let Some(glyph) = glyph else { continue };
            for (dy, row) in (0u32..).zip(glyph.rows()) {
                for (dx, &cover) in (0u32..).zip(row) {
                    self.blend(x + column * advance + dx, y + dy, colour, cover);
                }
            }
        }
    }

    fn blend(&mut self, x: u32, y: u32, colour: [u8; 3], cover: u8) {
        let Some(pixel) = self.image.get_pixel_mut_checked(x, y) else {
            return;
        };
        for (value, ink) in pixel.0.iter_mut().zip(colour) {
            let (cover, under, ink) = (u32::from(cover), u32::from(*value), u32::from(ink));
            *value = ((ink * cover + under * (255 - cover)) / 255) as u8;
        }
    }

    /// Draws a picture of `width` x `height` pixels into a square of `side`, its proportions kept and centred, framed.
    pub(super) fn picture(
        &mut self,
        (x, y): (u32, u32),
        side: u32,
        (width, height): (usize, usize),
        pixel: impl Fn(usize, usize) -> [u8; 3],
    ) {
        self.fill((x, y), (side, side), colour::FRAME);
        let inner = side.saturating_sub(2);
        let longer = width.max(height).max(1) as f64;
        let scale = f64::from(inner) / longer;
        let (shown_width, shown_height) = ((width as f64 * scale) as u32, (height as f64 * scale) as u32);
        let (left, top) = (x + 1 + (inner - shown_width) / 2, y + 1 + (inner - shown_height) / 2);
        self.fill((x + 1, y + 1), (inner, inner), [0; 3]);
        for dy in 0..shown_height {
            for dx in 0..shown_width {
                let source = (
                    (((f64::from(dx) + 0.5) / scale) as usize).min(width.saturating_sub(1)),
                    (((f64::from(dy) + 0.5) / scale) as usize).min(height.saturating_sub(1)),
                );
                self.pixel(left + dx, top + dy, pixel(source.0, source.1));
            }
        }
    }
}
