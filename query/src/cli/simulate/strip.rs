//! A trial's frames side by side, each with its caption below.

use grasp_answer::lettering::{self, Font};
use grasp_robot::simulation::Film;
use image::{Rgb, RgbImage};

/// The pixels below each frame for its caption.
const CAPTION: u32 = 26;
const INK: [u8; 3] = [40, 44, 52];

/// The strip of a film.
pub(super) fn strip(film: &Film) -> RgbImage {
    const SIDE: u32 = Film::SIDE;
    let width = SIDE * film.captions.len() as u32;
    let mut strip = RgbImage::from_pixel(width, SIDE + CAPTION, Rgb(Film::BACKGROUND));
    for ((at, frame), caption) in (0u32..).zip(&film.frames).zip(&film.captions) {
        image::imageops::replace(&mut strip, frame, i64::from(at * SIDE), 0);
        let left = at * SIDE + SIDE.saturating_sub(Font::BODY.width_of(caption)) / 2;
        lettering::write(&mut strip, (left, SIDE + 4), Font::BODY, caption, INK);
    }
    strip
}
