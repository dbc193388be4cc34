//! A picture to draw tiles, lines, text and pictures on.

use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use crate::lettering::{self, Font};

/// Pixels from one line of text to the next.
pub(crate) const LINE: u32 = 20;
/// The same for a headline.
pub(crate) const HEADLINE: u32 = 32;

/// Colours of the drawing.
pub(crate) mod colour {
    pub(crate) const PAPER: [u8; 3] = [24, 24, 28];
    pub(crate) const INK: [u8; 3] = [236, 236, 236];
    pub(crate) const FAINT: [u8; 3] = [164, 164, 170];
    pub(crate) const FRAME: [u8; 3] = [64, 64, 72];
    pub(crate) const GOOD: [u8; 3] = [110, 210, 130];
    pub(crate) const OTHER: [u8; 3] = [240, 160, 105];
    pub(crate) const FINGERS: [u8; 3] = [90, 190, 255];
    pub(crate) const BACK: [u8; 3] = [255, 190, 70];
    pub(crate) const ROBOT: [u8; 3] = [235, 120, 220];
}

/// A drawing; all that falls outside is left out.
#[derive(Debug)]
pub(crate) struct Canvas {
    image: RgbImage,
}

impl Canvas {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { image: RgbImage::from_pixel(width, height, Rgb(colour::PAPER)) }
    }

    /// Puts a picture with its top left corner at `(x, y)`, scaled to this size.
    pub(crate) fn put_sized(&mut self, (x, y): (u32, u32), size: [u32; 2], picture: &RgbImage) {
        let [width, height] = size;
        if (width, height) == picture.dimensions() {
            return imageops::replace(&mut self.image, picture, i64::from(x), i64::from(y));
        }
        if picture.width() > 0 && picture.height() > 0 {
            let scaled = imageops::resize(picture, width, height, FilterType::Triangle);
            imageops::replace(&mut self.image, &scaled, i64::from(x), i64::from(y));
        }
    }

    /// Makes what lies behind text dark.
    pub(crate) fn darken(&mut self, (x, y): (u32, u32), (width, height): (u32, u32)) {
        for dy in 0..height {
            for dx in 0..width {
                if let Some(Rgb(pixel)) = self.image.get_pixel_mut_checked(x + dx, y + dy) {
                    *pixel = pixel.map(|value| value / 3);
                }
            }
        }
    }

    pub(crate) fn into_image(self) -> RgbImage {
        self.image
    }

    pub(crate) fn fill(&mut self, (x, y): (u32, u32), (width, height): (u32, u32), colour: [u8; 3]) {
        for dy in 0..height {
            for dx in 0..width {
                if let Some(pixel) = self.image.get_pixel_mut_checked(x + dx, y + dy) {
                    *pixel = Rgb(colour);
                }
            }
        }
    }

    /// Writes a line with its top left corner at `(x, y)`, cut to `width` pixels: of what is longer
    /// the end is shown.
    pub(crate) fn text(&mut self, (x, y): (u32, u32), width: u32, font: Font, text: &str, colour: [u8; 3]) {
        let room = font.room(width);
        let shown: String = if text.chars().count() > room {
            // The end of a path says more than its beginning.
            let skip = text.chars().count() - room.saturating_sub(1);
            std::iter::once('~').chain(text.chars().skip(skip)).collect()
        } else {
            text.to_owned()
        };
        lettering::write(&mut self.image, (x, y), font, &shown, colour);
    }

    /// The same for a sentence: of what is longer the beginning is shown.
    pub(crate) fn line_of(&mut self, at: (u32, u32), width: u32, font: Font, text: &str, colour: [u8; 3]) {
        let room = font.room(width);
        let shown: String = match text.chars().count() > room {
            true => text.chars().take(room.saturating_sub(1)).chain(std::iter::once('~')).collect(),
            false => text.to_owned(),
        };
        lettering::write(&mut self.image, at, font, &shown, colour);
    }

    /// A straight line of this thickness with round ends, its edges smooth.
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], thickness: f64, colour: [u8; 3]) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length_squared = (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
        let reach = thickness / 2.0 + 1.0;
        let range = |a: f64, b: f64| {
            let low = (a.min(b) - reach).floor().max(0.0) as u32;
            low..=(a.max(b) + reach).ceil().max(0.0) as u32
        };
        for y in range(from[1], to[1]) {
            for x in range(from[0], to[0]) {
                let at = [f64::from(x) + 0.5 - from[0], f64::from(y) + 0.5 - from[1]];
                let share = ((at[0] * along[0] + at[1] * along[1]) / length_squared).clamp(0.0, 1.0);
                let apart = (at[0] - share * along[0]).hypot(at[1] - share * along[1]);
                let cover = (thickness / 2.0 + 0.5 - apart).clamp(0.0, 1.0);
                lettering::blend(&mut self.image, (x, y), colour, (255.0 * cover) as u8);
            }
        }
    }

    /// A line that ends in an arrowhead. Where it is too short to have a direction, a dot.
    pub(crate) fn arrow(&mut self, from: [f64; 2], to: [f64; 2], colour: [u8; 3]) {
        const THICKNESS: f64 = 4.0;
        const HEAD: f64 = 13.0;
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        self.line(from, to, THICKNESS, colour);
        if length < HEAD / 2.0 {
            return self.line(to, to, 2.5 * THICKNESS, colour);
        }
        let (ux, uy) = (dx / length, dy / length);
        for side in [-0.55, 0.55] {
            let barb = [to[0] - HEAD * (ux - side * uy), to[1] - HEAD * (uy + side * ux)];
            self.line(to, barb, THICKNESS, colour);
        }
    }

    /// Draws a picture into a square of `side` pixels, its proportions kept and centred, framed;
    /// what it does not fill is `ground`. Returns where its top left corner lies and by how much it
    /// was scaled.
    pub(crate) fn picture(
        &mut self,
        (x, y): (u32, u32),
        side: u32,
        picture: &RgbImage,
        ground: [u8; 3],
    ) -> ([f64; 2], f64) {
        self.fill((x, y), (side, side), colour::FRAME);
        let inner = side.saturating_sub(2);
        self.fill((x + 1, y + 1), (inner, inner), ground);
        let (width, height) = picture.dimensions();
        let scale = f64::from(inner) / f64::from(width.max(height).max(1));
        let shown = |length: u32| ((f64::from(length) * scale) as u32).clamp(1, inner.max(1));
        let (shown_width, shown_height) = (shown(width), shown(height));
        let (left, top) = (x + 1 + (inner - shown_width) / 2, y + 1 + (inner - shown_height) / 2);
        if width > 0 && height > 0 {
            // Smooth: what is seen are fingers and not the squares that they were stored as.
            let scaled = imageops::resize(picture, shown_width, shown_height, FilterType::CatmullRom);
            imageops::replace(&mut self.image, &scaled, i64::from(left), i64::from(top));
        }
        ([f64::from(left), f64::from(top)], scale)
    }
}
