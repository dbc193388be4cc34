//! Hands in front of backgrounds that are hard to tell from skin, and such backgrounds alone.

use image::imageops::{self, FilterType};
use image::{GrayImage, Luma, Rgb, Rgb32FImage, Rgba, RgbaImage};

use super::draws::Draws;
use grasp_recognise::picture::Picture;
use grasp_recognise::segment::Mask;

/// Sizes of pictures: width and height.
const SIZES: [[u32; 2]; 3] = [[128, 128], [256, 192], [320, 240]];
/// The share of a picture's shorter side that a hand spans.
const SPAN: [f64; 2] = [0.4, 0.95];
/// How far beyond the picture a hand may be shifted, as a share of what is left free.
const BEYOND: f64 = 0.05;
/// How light skin is beside [`SKIN`].
const LIGHTNESS: [f64; 2] = [0.5, 1.2];
/// The colour of skin in good light.
const SKIN: [f64; 3] = [200.0, 145.0, 115.0];

/// The hand of a segmented picture, cut out: transparent where it is not.
pub(super) fn cut_out(picture: &Picture, mask: &Mask) -> Option<RgbaImage> {
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    let pixels = picture.rgb().iter().zip(mask.pixels());
    let bytes = pixels.flat_map(|(&[r, g, b], &inside)| [r, g, b, 255 * inside]).collect();
    let whole = RgbaImage::from_raw(width, height, bytes)?;
    let inside = || whole.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] > 0);
    let (left, right) = (inside().map(|(x, ..)| x).min()?, inside().map(|(x, ..)| x).max()?);
    let (top, bottom) = (inside().map(|(_, y, _)| y).min()?, inside().map(|(_, y, _)| y).max()?);
    Some(imageops::crop_imm(&whole, left, top, right + 1 - left, bottom + 1 - top).to_image())
}

/// A hand somewhere before some background.
pub(super) fn hand(hand: &RgbaImage, draws: &mut Draws) -> Option<Picture> {
    let [width, height] = SIZES[draws.below(SIZES.len())];
    let mut canvas = background(width, height, draws);
    let longest = f64::from(hand.width().max(hand.height()));
    let scale = draws.between(SPAN[0], SPAN[1]) * f64::from(width.min(height)) / longest;
    let side = |length: u32| ((f64::from(length) * scale) as u32).max(8);
    let hand = imageops::resize(hand, side(hand.width()), side(hand.height()), FilterType::Triangle);
    let free = |whole: u32, part: u32| f64::from(whole) - f64::from(part);
    let left = draws.between(-BEYOND, 1.0 + BEYOND) * free(width, hand.width());
    let top = draws.between(-BEYOND, 1.0 + BEYOND) * free(height, hand.height());
    for (x, y, &Rgba([r, g, b, alpha])) in hand.enumerate_pixels() {
        let (x, y) = (i64::from(x) + left as i64, i64::from(y) + top as i64);
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { continue };
        if let Some(below) = canvas.get_pixel_mut_checked(x, y) {
            let share = f32::from(alpha) / 255.0;
            for (below, above) in below.0.iter_mut().zip([r, g, b]) {
                *below = share * f32::from(above) + (1.0 - share) * *below;
            }
        }
    }
    photograph(canvas, draws)
}

/// A background with up to three things on it that have the colour of skin.
pub(super) fn no_hand(draws: &mut Draws) -> Option<Picture> {
    let [width, height] = SIZES[draws.below(SIZES.len())];
    let mut canvas = background(width, height, draws);
    for _ in 0..draws.below(4) {
        let colour = colour(1.0, draws);
        let is_round = draws.below(2) == 0;
        let [x, y] = [width, height].map(|side| draws.between(0.0, f64::from(side)));
        let [across, down] = [width, height].map(|side| f64::from(side) * draws.between(0.04, 0.25));
        for (column, row, pixel) in canvas.enumerate_pixels_mut() {
            let [u, v] = [(f64::from(column) - x) / across, (f64::from(row) - y) / down];
            if if is_round { u.hypot(v) <= 1.0 } else { u.abs().max(v.abs()) <= 1.0 } {
                *pixel = Rgb(colour);
            }
        }
    }
    photograph(canvas, draws)
}

/// Some colour: that of skin where `near` is 1, any where it is 0.
fn colour(near: f64, draws: &mut Draws) -> [f32; 3] {
    let light = draws.between(LIGHTNESS[0], LIGHTNESS[1]);
    SKIN.map(|skin| {
        let any = draws.between(20.0, 235.0);
        (near * (skin * light + draws.about(12.0)) + (1.0 - near) * any) as f32
    })
}

/// Smooth noise, 0..=1, whose waves are `across` x `down` pixels.
fn noise(width: u32, height: u32, [across, down]: [u32; 2], draws: &mut Draws) -> GrayImage {
    let mut coarse = GrayImage::new(width / across.max(1) + 2, height / down.max(1) + 2);
    coarse.pixels_mut().for_each(|pixel| *pixel = Luma([draws.below(256) as u8]));
    imageops::resize(&coarse, width, height, FilterType::CatmullRom)
}

fn background(width: u32, height: u32, draws: &mut Draws) -> Rgb32FImage {
    let near: f64 = [0.0, 0.0, 0.5, 1.0][draws.below(4)];
    let kind = draws.below(4);
    let first = colour(if kind == 1 { near.max(0.5) } else { near }, draws);
    let second = colour([0.0, 0.5][draws.below(2)], draws);
    let waves = match kind {
        0 => [width, height],
        1 if draws.below(2) == 0 => [60, 3],
        1 => [3, 60],
        2 => [6, 6],
        _ => [20, 20],
    };
    let noise = noise(width, height, waves, draws);
    let wave = |x: u32, y: u32| f32::from(noise.get_pixel(x, y).0[0]) / 255.0;
    let mut canvas = Rgb32FImage::from_fn(width, height, |x, y| match (kind, wave(x, y) - 0.5) {
        // Cloth has two colours, wood waves of one, a wall a shade, and clutter things before a
        // wall.
        (2, wave) => Rgb(if wave > 0.0 { first } else { second }),
        (_, wave) => Rgb(first.map(|value| value + 60.0 * wave)),
    });
    for _ in 0..if kind == 3 { 4 + draws.below(12) } else { 0 } {
        let thing = colour([0.0, 0.0, 0.5, 1.0][draws.below(4)], draws);
        let [left, top] = [width, height].map(|side| draws.below(side as usize) as u32);
        let [across, down] =
            [width, height].map(|side| draws.between(0.1, 0.5) * f64::from(side)).map(|side| side as u32);
        for y in top..(top + down).min(height) {
            for x in left..(left + across).min(width) {
                canvas.put_pixel(x, y, Rgb(thing));
            }
        }
    }
    canvas
}

/// What a poor camera makes of it: the light's colour, noise, and for every other picture a blur.
fn photograph(mut canvas: Rgb32FImage, draws: &mut Draws) -> Option<Picture> {
    let level = draws.between(0.55, 1.15);
    let light = [1.0 + draws.about(0.06), 1.0, 1.0 + draws.about(0.08)].map(|cast| (level * cast) as f32);
    let grain = draws.between(0.0, 6.0);
    for pixel in canvas.pixels_mut() {
        for (value, light) in pixel.0.iter_mut().zip(light) {
            *value = *value * light + draws.about(grain) as f32;
        }
    }
    if draws.below(2) == 0 {
        canvas = imageops::blur(&canvas, draws.between(0.3, 1.5) as f32);
    }
    let rgb = canvas.pixels().map(|pixel| pixel.0.map(|value| value.clamp(0.0, 255.0) as u8)).collect();
    Picture::new(canvas.width() as usize, canvas.height() as usize, rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_draws_make_the_same_picture_and_the_hand_is_in_it() {
        let green = Picture::new(20, 30, vec![[0, 255, 0]; 600]).unwrap();
        let all = Mask::from_values(20, 30, &[1; 600], |v| v == 1);
        let cut = cut_out(&green, &all).unwrap();
        let picture = hand(&cut, &mut Draws::of("a.png", 1)).unwrap();
        assert_eq!(Some(&picture), hand(&cut, &mut Draws::of("a.png", 1)).as_ref());
        assert_ne!(Some(&picture), hand(&cut, &mut Draws::of("a.png", 2)).as_ref());
        let is_green = |[r, g, b]: &&[u8; 3]| *g > 100 && *r < 60 && *b < 60;
        let share = picture.rgb().iter().filter(is_green).count() as f64 / picture.rgb().len() as f64;
        assert!((0.03..0.8).contains(&share), "{share}");
        assert_eq!(cut_out(&green, &Mask::from_values(20, 30, &[0; 600], |v| v == 1)), None);
    }
}
