//! A picture's colours as they would be under a standard light.

use crate::picture::Picture;

/// The brightness that the brightest part of a picture is brought to: that of the web's
/// photographs.
const WHITE: f32 = 230.0;
/// The share of values below "the brightest part".
const BRIGHT_SHARE: f64 = 0.95;
/// A picture is made at most this much brighter.
const MOST_GAIN: f32 = 1.8;

/// What each channel's value becomes under a standard light: a table, because a gain is applied to
/// every pixel.
pub(super) struct Light {
    tables: [[u8; 256]; 3],
}

impl Light {
    /// Takes the 95th percentile of each channel for white (the white-patch assumption); `cast`,
    /// 0..=1, is how much of the colour cast is taken out.
    pub(super) fn of(picture: &Picture, cast: f32) -> Self {
        let mut histogram = [[0usize; 256]; 3];
        for pixel in picture.rgb() {
            for (counts, &value) in histogram.iter_mut().zip(pixel) {
                counts[usize::from(value)] += 1;
            }
        }
        let below = (BRIGHT_SHARE * picture.rgb().len() as f64) as usize;
        let bright = histogram.map(|counts| {
            let mut sum = 0;
            let at = counts.iter().position(|&count| {
                sum += count;
                sum > below
            });
            at.unwrap_or(255).max(1) as f32
        });
        let mean = (bright[0] + bright[1] + bright[2]) / 3.0;
        let gain = (WHITE / mean).clamp(1.0, MOST_GAIN);
        let tables = bright.map(|bright| {
            let channel = gain * libm::powf(mean / bright, cast).clamp(0.8, 1.25);
            std::array::from_fn(|value| (value as f32 * channel).round().min(255.0) as u8)
        });
        Self { tables }
    }

    pub(super) fn correct(&self, rgb: [u8; 3]) -> [u8; 3] {
        let [red, green, blue] = &self.tables;
        [red[usize::from(rgb[0])], green[usize::from(rgb[1])], blue[usize::from(rgb[2])]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(rgb: [u8; 3]) -> Picture {
        Picture::new(8, 8, vec![rgb; 64]).unwrap()
    }

    #[test]
    fn a_dim_picture_is_made_brighter_and_a_bright_one_stays() {
        assert_eq!(Light::of(&flat([100; 3]), 0.5).correct([50; 3]), [90; 3]);
        assert_eq!(Light::of(&flat([240; 3]), 0.5).correct([50; 3]), [50; 3]);
    }

    #[test]
    fn a_blue_cast_is_taken_out_as_far_as_asked() {
        let blue = flat([200, 200, 240]);
        let [r, _, b] = Light::of(&blue, 0.0).correct([200, 200, 240]);
        assert!(b > r + 30);
        let [r, _, b] = Light::of(&blue, 1.0).correct([200, 200, 240]);
        assert!(b.abs_diff(r) <= 2);
    }
}
