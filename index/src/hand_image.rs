//! The hand image H of the paper's Section III: segmented, cropped to the hand, grey, black outside
//! the hand.

pub(crate) mod upright;

use crate::resample::{Axis, Resampler};
use thiserror::Error;

/// The smallest side of a hand image, in pixels: below it the finest cells of a descriptor hold
/// nothing to measure.
pub const MIN_SIDE: usize = 8;

/// A segmented hand, cropped to the box of its mask: grey inside the hand, 0 outside.
///
/// ```
/// use grasp_index::HandImage;
/// let mut grey = vec![0u8; 20 * 30];
/// for y in 5..25 { for x in 4..16 { grey[y * 20 + x] = 120; } }
/// let hand = HandImage::from_segmented(20, 30, &grey, 0)?;
/// assert_eq!((hand.width(), hand.height()), (12, 20));
/// # Ok::<(), grasp_index::HandImageError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HandImage {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
    mask: Vec<u8>,
}

/// Why a picture is no hand image.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum HandImageError {
    /// No pixel belongs to the hand.
    #[error("no hand found: no pixel of the {width} x {height} picture belongs to a hand")]
    NoHand {
        /// The picture's width in pixels.
        width: usize,
        /// The picture's height in pixels.
        height: usize,
    },
    /// The hand's box is too small to describe.
    #[error("the hand is {width} x {height} pixels; at least {min} x {min} are needed: move closer or use a larger picture", min = MIN_SIDE)]
    TooSmall {
        /// The width of the hand's box in pixels.
        width: usize,
        /// The height of the hand's box in pixels.
        height: usize,
    },
    /// The buffers do not have one value a pixel.
    #[error("a {width} x {height} picture needs {} values, but {what} holds {found}", width.saturating_mul(*height))]
    SizeMismatch {
        /// The width that was stated, in pixels.
        width: usize,
        /// The height that was stated, in pixels.
        height: usize,
        /// Which buffer does not fit: `grey` or `mask`.
        what: &'static str,
        /// How many values it holds.
        found: usize,
    },
}

/// What segmented pictures have outside the hand, at most: black, which other programs' pictures do
/// not always have quite. A hand in a picture of this project has 16 or more.
pub const BACKGROUND: u8 = 8;

/// The longest side, in pixels, at which hand images are described: that of this project's renders.
/// Larger ones are [shrunk](HandImage::shrunk_to), so that all are described at one scale.
pub const DESCRIBED_SIDE: usize = 48;

impl HandImage {
    /// Cuts the hand out of a grey picture. `grey` and `mask` are row-major, `width * height`
    /// values each; a mask value other than 0 is hand.
    ///
    /// # Errors
    /// [`HandImageError`], when the buffers do not fit the size or the mask holds no hand of at
    /// least [`MIN_SIDE`] pixels a side.
    pub fn from_mask(width: usize, height: usize, grey: &[u8], mask: &[u8]) -> Result<Self, HandImageError> {
        check_size(width, height, "grey", grey.len())?;
        check_size(width, height, "mask", mask.len())?;
        Self::crop(width, height, grey, |at| mask[at] != 0)
    }

    /// Takes a picture that is segmented already: every pixel brighter than `floor` is hand. 0
    /// serves renders, about 16 pictures that went through JPEG, whose black rings.
    ///
    /// # Errors
    /// [`HandImageError`], when the buffer does not fit the size or holds no hand of at least
    /// [`MIN_SIDE`] pixels a side.
    pub fn from_segmented(
        width: usize,
        height: usize,
        grey: &[u8],
        floor: u8,
    ) -> Result<Self, HandImageError> {
        check_size(width, height, "grey", grey.len())?;
        Self::crop(width, height, grey, |at| grey[at] > floor)
    }

    fn crop(
        width: usize,
        height: usize,
        grey: &[u8],
        is_hand: impl Fn(usize) -> bool,
    ) -> Result<Self, HandImageError> {
        let hand = Self::crop_any_size(width, height, grey, is_hand)
            .ok_or(HandImageError::NoHand { width, height })?;
        if hand.width < MIN_SIDE || hand.height < MIN_SIDE {
            return Err(HandImageError::TooSmall { width: hand.width, height: hand.height });
        }
        Ok(hand)
    }

    /// `None` where no pixel is hand.
    fn crop_any_size(
        width: usize,
        height: usize,
        grey: &[u8],
        is_hand: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let (mut left, mut right, mut top, mut bottom) = (width, 0, height, 0);
        for y in 0..height {
            let line = y * width;
            let Some(first) = (0..width).find(|x| is_hand(line + x)) else {
                continue;
            };
            let last = (first..width).rfind(|x| is_hand(line + x)).unwrap_or(first);
            left = left.min(first);
            right = right.max(last + 1);
            top = top.min(y);
            bottom = y + 1;
        }
        if left >= right {
            return None;
        }
        let area = (right - left) * (bottom - top);
        let (mut pixels, mut mask) = (Vec::with_capacity(area), Vec::with_capacity(area));
        for at in (top..bottom).flat_map(|y| y * width + left..y * width + right) {
            let inside = is_hand(at);
            pixels.push(if inside { grey[at] } else { 0 });
            mask.push(u8::from(inside));
        }
        Some(Self { width: right - left, height: bottom - top, pixels, mask })
    }

    /// The width of the hand's box, in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height of the hand's box, in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The grey values, row-major, `width * height` of them; 0 outside the hand.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// 1 where a pixel is hand, 0 elsewhere; row-major, `width * height` values.
    pub fn mask(&self) -> &[u8] {
        &self.mask
    }

    /// The picture flipped left to right: a left hand becomes a right one.
    pub fn mirrored(&self) -> Self {
        let flip = |values: &[u8]| {
            values.chunks_exact(self.width).flat_map(|row| row.iter().rev().copied()).collect()
        };
        Self { width: self.width, height: self.height, pixels: flip(&self.pixels), mask: flip(&self.mask) }
    }

    /// The hand as a camera sees it when the hand is turned by `radians` about the optical axis (z
    /// forward, x right, y down: a positive angle is clockwise on the picture), cropped anew. Where
    /// the hand had the orientation `camera_from_hand`, it now has `Rz(radians) *
    /// camera_from_hand`.
    pub fn rotated(&self, radians: f64) -> Self {
        if radians == 0.0 {
            return self.clone();
        }
        let (sin, cos) = libm::sincos(radians);
        let (w, h) = (self.width as f64, self.height as f64);
        // The last digits of a quarter turn's sine must not add a pixel.
        let pixels_of = |length: f64| (length - 1e-6).ceil().max(1.0) as usize;
        let out_width = pixels_of(w * cos.abs() + h * sin.abs());
        let out_height = pixels_of(w * sin.abs() + h * cos.abs());
        let mut pixels = vec![0u8; out_width * out_height];
        let mut mask = vec![0u8; out_width * out_height];
        for y in 0..out_height {
            let dy = y as f64 + 0.5 - out_height as f64 / 2.0;
            for x in 0..out_width {
                let dx = x as f64 + 0.5 - out_width as f64 / 2.0;
                let source_x = cos * dx + sin * dy + w / 2.0 - 0.5;
                let source_y = -sin * dx + cos * dy + h / 2.0 - 0.5;
                if let Some(grey) = self.sample(source_x, source_y) {
                    pixels[y * out_width + x] = grey;
                    mask[y * out_width + x] = 1;
                }
            }
        }
        // A hand of a few scattered pixels can fall between the samples; it then stays as it was.
        Self::crop_any_size(out_width, out_height, &pixels, |at| mask[at] != 0)
            .unwrap_or_else(|| self.clone())
    }

    /// Linear interpolation between the pixels of the hand around `(x, y)`; `None` where less than
    /// half of the weight is hand. Pixels beyond the picture count for nothing.
    fn sample(&self, x: f64, y: f64) -> Option<u8> {
        let (left, top) = (floor(x), floor(y));
        let (fx, fy) = (x - left as f64, y - top as f64);
        let (gx, gy) = (1.0 - fx, 1.0 - fy);
        let weights = [gx * gy, fx * gy, gx * fy, fx * fy];
        let (mut inside, mut grey) = (0.0, 0.0);
        let mut take = |at: usize, weight: f64| {
            inside += weight * f64::from(self.mask[at]);
            grey += weight * f64::from(self.pixels[at]);
        };
        let (width, height) = (self.width as i64, self.height as i64);
        if (0..width - 1).contains(&left) && (0..height - 1).contains(&top) {
            let at = (top * width + left) as usize;
            let below = at + self.width;
            [at, at + 1, below, below + 1].into_iter().zip(weights).for_each(|(at, weight)| take(at, weight));
        } else {
            for ((dx, dy), weight) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().zip(weights) {
                let (x, y) = (left + dx, top + dy);
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    take((y * width + x) as usize, weight);
                }
            }
        }
        (inside >= 0.5).then(|| (grey / inside).round() as u8)
    }

    /// The hand image shrunk so that its longer side is at most `side` pixels, never below
    /// [`MIN_SIDE`]; smaller ones are returned as they are. Worth doing once before a large picture
    /// is turned and described many times.
    pub fn shrunk_to(&self, side: usize) -> Self {
        let longer = self.width.max(self.height);
        let side = side.max(MIN_SIDE);
        if longer <= side {
            return self.clone();
        }
        let scaled = |length: usize| ((length * side) as f64 / longer as f64).round().max(1.0) as usize;
        let (width, height) = (scaled(self.width), scaled(self.height));
        let across =
            Axis { source: self.width, samples: width, origin: 0.0, step: self.width as f32 / width as f32 };
        let down = Axis {
            source: self.height,
            samples: height,
            origin: 0.0,
            step: self.height as f32 / height as f32,
        };
        let mut share = vec![0.0; width * height];
        let mut grey = vec![0.0; width * height];
        let mut resampler = Resampler::default();
        let mut take = |values: &[u8], out: &mut [f32]| {
            resampler.run(across, down, |y, row| to_floats(&values[y * self.width..], row), out, 0, width);
        };
        take(&self.mask, &mut share);
        take(&self.pixels, &mut grey);
        let pixels: Vec<u8> = grey.iter().zip(&share).map(|(g, s)| (g / s.max(1e-6)).round() as u8).collect();
        // Half of a border pixel's filter lies outside the picture, so less than half of its weight
        // may be hand.
        Self::crop_any_size(width, height, &pixels, |at| share[at] >= 0.4).unwrap_or_else(|| self.clone())
    }

    /// A square grey picture of `side * side` values, row-major: the hand image with its aspect
    /// kept, centred on black.
    pub fn thumbnail(&self, side: usize) -> Vec<u8> {
        if side == 0 {
            return Vec::new();
        }
        let step = self.width.max(self.height) as f32 / side as f32;
        let axis = |source: usize| Axis {
            source,
            samples: side,
            origin: (source as f32 - step * side as f32) / 2.0,
            step,
        };
        let mut out = vec![0.0; side * side];
        let row = |y: usize, row: &mut [f32]| to_floats(&self.pixels[y * self.width..], row);
        Resampler::default().run(axis(self.width), axis(self.height), row, &mut out, 0, side);
        out.iter().map(|grey| grey.round() as u8).collect()
    }
}

fn check_size(width: usize, height: usize, what: &'static str, found: usize) -> Result<(), HandImageError> {
    if width.checked_mul(height) == Some(found) {
        Ok(())
    } else {
        Err(HandImageError::SizeMismatch { width, height, what, found })
    }
}

/// The largest integer that is not above `value`. The same as `f64::floor`, which is a call on
/// processors whose instructions are not known when the program is compiled.
fn floor(value: f64) -> i64 {
    let towards_zero = value as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > value))
}

fn to_floats(values: &[u8], row: &mut [f32]) {
    for (float, value) in row.iter_mut().zip(values) {
        *float = f32::from(*value);
    }
}

#[cfg(test)]
mod tests;
