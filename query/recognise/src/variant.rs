//! Variants of a picture that a person answers alike: changed a little. `--thorough` joins what is
//! said of them (test-time augmentation), and `experiment steadiness` compares it.

use grasp_index::{mirror_orientation, turned_orientation};
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use nalgebra::UnitQuaternion;

use crate::picture::Picture;
use crate::segment::Mask;
use crate::side::{HandChoice, Side};

/// How far a camera is held aslant, in degrees.
const TURN_DEG: f64 = 8.0;
/// The exponent of a darker picture's values; a brighter one's is its inverse.
const DARKER: f32 = 1.25;
/// How much more red and less blue there is in warmer light.
const WARMER: f32 = 0.06;
/// The share of colour that is left in a paler picture.
const PALER: f32 = 0.75;
/// The standard deviation of the blur, as a share of the longer side.
const BLUR: f32 = 1.0 / 300.0;
/// How many times as large an enlarged picture is.
const LARGER: f64 = 1.2;
/// The share of a picture that is cut off at one side.
const CUT: f64 = 0.05;

/// One of the variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// As it is.
    AsItIs,
    /// Its mirror image, which shows the other hand.
    Mirrored,
    /// Turned clockwise.
    TurnedRight,
    /// Turned the other way.
    TurnedLeft,
    /// Less light.
    Darker,
    /// More light.
    Brighter,
    /// More red and less blue.
    Warmer,
    /// Less red and more blue.
    Colder,
    /// Less colour.
    Paler,
    /// Slightly out of focus.
    Blurred,
    /// More pixels.
    Enlarged,
    /// Without its left border.
    CutLeft,
    /// Without its right border.
    CutRight,
    /// Without its upper border.
    CutAbove,
}

impl Variant {
    /// All of them, in the order of tables; the first is the picture as it is.
    pub const ALL: [Self; 14] = [
        Self::AsItIs,
        Self::Mirrored,
        Self::TurnedRight,
        Self::TurnedLeft,
        Self::Darker,
        Self::Brighter,
        Self::Warmer,
        Self::Colder,
        Self::Paler,
        Self::Blurred,
        Self::Enlarged,
        Self::CutLeft,
        Self::CutRight,
        Self::CutAbove,
    ];

    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "as it is",
            Self::Mirrored => "mirrored",
            Self::TurnedRight => "turned right",
            Self::TurnedLeft => "turned left",
            Self::Darker => "darker",
            Self::Brighter => "brighter",
            Self::Warmer => "warmer",
            Self::Colder => "colder",
            Self::Paler => "paler",
            Self::Blurred => "blurred",
            Self::Enlarged => "enlarged",
            Self::CutLeft => "cut left",
            Self::CutRight => "cut right",
            Self::CutAbove => "cut above",
        }
    }

    /// The hand that a picture of this variant shows, of the hand in the picture as it is, and the
    /// reverse.
    pub fn side(self, side: Side) -> Side {
        if self == Self::Mirrored { side.other() } else { side }
    }

    /// The same of a choice of hands.
    pub fn hand(self, hand: HandChoice) -> HandChoice {
        match (self, hand) {
            (Self::Mirrored, HandChoice::Left) => HandChoice::Right,
            (Self::Mirrored, HandChoice::Right) => HandChoice::Left,
            _ => hand,
        }
    }

    /// `camera_from_hand` in a picture of this variant.
    pub fn orientation(self, camera_from_hand: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        match self {
            Self::Mirrored => mirror_orientation(camera_from_hand),
            _ => turned_orientation(self.turn_deg(), camera_from_hand),
        }
    }

    /// `camera_from_hand` in the picture as it is, where it is this one in a picture of this
    /// variant.
    pub fn orientation_as_it_is(self, camera_from_hand: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        match self {
            Self::Mirrored => mirror_orientation(camera_from_hand),
            _ => turned_orientation(-self.turn_deg(), camera_from_hand),
        }
    }

    /// How far pictures of this variant are turned, clockwise.
    fn turn_deg(self) -> f64 {
        match self {
            Self::TurnedRight => TURN_DEG,
            Self::TurnedLeft => -TURN_DEG,
            _ => 0.0,
        }
    }

    /// The picture in this variant.
    pub fn picture(self, picture: &Picture) -> Picture {
        picture_of(&self.changed(&image_of(picture)))
    }

    /// The mask of the picture in this variant, of its mask as it is.
    pub fn mask(self, mask: &Mask) -> Mask {
        let pixels = mask.pixels().iter().flat_map(|inside| [255 * *inside; 3]).collect();
        let image = image_from(mask.width(), mask.height(), pixels);
        let placed = self.placed(&image);
        let values: Vec<u8> = placed.pixels().map(|pixel| pixel.0[0]).collect();
        Mask::from_grey(placed.width() as usize, placed.height() as usize, &values)
    }

    fn changed(self, picture: &RgbImage) -> RgbImage {
        let graded = |grade: &dyn Fn([f32; 3]) -> [f32; 3]| {
            let mut picture = picture.clone();
            for Rgb(rgb) in picture.pixels_mut() {
                *rgb = grade(rgb.map(|value| f32::from(value) / 255.0))
                    .map(|value| (255.0 * value).round() as u8);
            }
            picture
        };
        let lit = |exponent: f32| graded(&|rgb| rgb.map(|value| libm::powf(value, exponent)));
        let warm = |more: f32| graded(&|[r, g, b]| [r * (1.0 + more), g, b * (1.0 - more)]);
        match self {
            Self::Darker => lit(DARKER),
            Self::Brighter => lit(1.0 / DARKER),
            Self::Warmer => warm(WARMER),
            Self::Colder => warm(-WARMER),
            Self::Paler => graded(&|rgb| {
                let grey = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
                rgb.map(|value| grey + PALER * (value - grey))
            }),
            Self::Blurred => imageops::blur(picture, BLUR * picture.width().max(picture.height()) as f32),
            _ => self.placed(picture),
        }
    }

    /// With everything where a picture of this variant has it, in the colours as they were.
    fn placed(self, picture: &RgbImage) -> RgbImage {
        let (width, height) = picture.dimensions();
        let without = |left: f64, above: f64, right: f64| {
            let [left, right] = [left, right].map(|share| (share * f64::from(width)) as u32);
            let above = (above * f64::from(height)) as u32;
            imageops::crop_imm(picture, left, above, width - left - right, height - above).to_image()
        };
        match self {
            Self::Mirrored => imageops::flip_horizontal(picture),
            Self::TurnedRight => turned(picture, TURN_DEG),
            Self::TurnedLeft => turned(picture, -TURN_DEG),
            Self::Enlarged => {
                let [width, height] = [width, height].map(|side| (f64::from(side) * LARGER) as u32);
                imageops::resize(picture, width, height, FilterType::CatmullRom)
            }
            Self::CutLeft => without(CUT, 0.0, 0.0),
            Self::CutRight => without(0.0, 0.0, CUT),
            Self::CutAbove => without(0.0, CUT, 0.0),
            _ => picture.clone(),
        }
    }
}

fn image_of(picture: &Picture) -> RgbImage {
    image_from(picture.width(), picture.height(), picture.rgb().as_flattened().to_vec())
}

fn image_from(width: usize, height: usize, bytes: Vec<u8>) -> RgbImage {
    RgbImage::from_raw(width as u32, height as u32, bytes).expect("a picture has as many pixels as it says")
}

fn picture_of(image: &RgbImage) -> Picture {
    let pixels = image.pixels().map(|pixel| pixel.0).collect();
    Picture::new(image.width() as usize, image.height() as usize, pixels)
        .expect("a picture of every variant has sides")
}

/// A picture turned clockwise about its middle; beyond its border lies its mirror image, which has
/// no edge there.
fn turned(picture: &RgbImage, turn_deg: f64) -> RgbImage {
    let (width, height) = picture.dimensions();
    let (sin, cos) = libm::sincos(turn_deg.to_radians());
    let [across, down] = [width, height].map(|side| 0.5 * (f64::from(side) - 1.0));
    let inside = |place: f64, last: f64| {
        let place = place.abs();
        (if place > last { 2.0 * last - place } else { place }).clamp(0.0, last) as f32
    };
    RgbImage::from_fn(width, height, |x, y| {
        let (x, y) = (f64::from(x) - across, f64::from(y) - down);
        let place = [across + cos * x + sin * y, down + cos * y - sin * x];
        let [x, y] = [inside(place[0], 2.0 * across), inside(place[1], 2.0 * down)];
        imageops::interpolate_bilinear(picture, x, y).unwrap_or(Rgb([0; 3]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture whose colours differ everywhere.
    fn shaded() -> RgbImage {
        RgbImage::from_fn(240, 160, |x, y| Rgb([x as u8, y as u8, 100 + 2 * ((x + y) % 9) as u8]))
    }

    #[test]
    fn every_change_but_none_changes_a_picture_and_keeps_it_much_as_it_was() {
        let picture = shaded();
        for variant in Variant::ALL {
            let changed = variant.changed(&picture);
            assert_eq!(changed == picture, variant == Variant::AsItIs, "{}", variant.name());
            let mean = |picture: &RgbImage| {
                picture.as_raw().iter().map(|value| f64::from(*value)).sum::<f64>()
                    / picture.as_raw().len() as f64
            };
            assert!((mean(&changed) - mean(&picture)).abs() < 20.0, "{}", variant.name());
        }
        let names: std::collections::BTreeSet<_> = Variant::ALL.map(Variant::name).into();
        assert_eq!(names.len(), Variant::ALL.len());
    }

    #[test]
    fn a_mask_goes_where_its_picture_goes() {
        let picture = shaded();
        for variant in Variant::ALL {
            let (changed, mask) = (variant.changed(&picture), variant.placed(&picture));
            assert_eq!(changed.dimensions(), mask.dimensions(), "{}", variant.name());
        }
        // What was right of the middle lies below it after a turn clockwise.
        let mut mask = RgbImage::new(101, 101);
        mask.put_pixel(90, 50, Rgb([255; 3]));
        let changed = Variant::TurnedRight.placed(&mask);
        let brightest = changed.enumerate_pixels().max_by_key(|(.., pixel)| pixel.0[0]);
        let (x, y, _) = brightest.unwrap();
        let (sin, cos) = libm::sincos(TURN_DEG.to_radians());
        assert!((f64::from(x) - 50.0 - 40.0 * cos).abs() < 1.0, "{x}");
        assert!((f64::from(y) - 50.0 - 40.0 * sin).abs() < 1.0, "{y}");
    }

    #[test]
    fn a_picture_that_is_turned_there_and_back_is_as_it_was_but_for_its_border() {
        let picture = shaded();
        let back = Variant::TurnedLeft.placed(&Variant::TurnedRight.placed(&picture));
        for (x, y, pixel) in picture.enumerate_pixels() {
            if (30..210).contains(&x) && (30..130).contains(&y) {
                let apart = pixel.0.iter().zip(back.get_pixel(x, y).0).take(2).map(|(a, b)| a.abs_diff(b));
                assert!(apart.max().unwrap() <= 1, "{x} {y}");
            }
        }
    }

    #[test]
    fn a_picture_of_one_pixel_is_changed_like_any_other() {
        for variant in Variant::ALL {
            let changed = variant.changed(&RgbImage::from_pixel(1, 1, Rgb([9, 9, 9])));
            assert_eq!(changed.dimensions(), (1, 1), "{}", variant.name());
        }
    }
}
