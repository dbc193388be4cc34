//! A square part of a picture, turned, as the network's input.

use crate::picture::Picture;
use crate::segment::Mask;
use multiversion::multiversion;

/// A square of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Its middle in pixels, right and down.
    pub centre: [f64; 2],
    /// Its side in pixels.
    pub side: f64,
    /// By how many radians its content is turned clockwise to be looked at.
    pub turn: f64,
}

impl Square {
    /// The smallest square around a whole picture.
    pub fn around(picture: &Picture) -> Self {
        let [width, height] = [picture.width() as f64, picture.height() as f64];
        Self { centre: [0.5 * width, 0.5 * height], side: width.max(height), turn: 0.0 }
    }

    /// From places of the square, 0 to 1 right and down, to places of the picture, in pixels.
    pub fn to_picture(&self) -> Map {
        let (sin, cos) = libm::sincos(self.turn);
        let [cos, sin] = [cos * self.side, sin * self.side];
        let [x, y] = self.centre;
        Map([[cos, sin, x - 0.5 * (cos + sin)], [-sin, cos, y - 0.5 * (cos - sin)]])
    }

    /// From places of the picture, in pixels, to places of the square.
    pub fn from_picture(&self) -> Map {
        let (sin, cos) = libm::sincos(self.turn);
        let [cos, sin] = [cos / self.side, sin / self.side];
        let [x, y] = self.centre;
        Map([[cos, -sin, 0.5 - cos * x + sin * y], [sin, cos, 0.5 - sin * x - cos * y]])
    }

    /// The square as `side` by `side` pixels of red, green and blue, -1 to 1; what lies beyond the
    /// picture's border looks like the border.
    pub(super) fn planes(&self, texels: &Texels, side: usize, planes: &mut Vec<f32>) {
        planes.resize(3 * side * side, 0.0);
        fill(self, texels, side, planes);
    }

    /// The same where a pixel shows less than one of the picture's: between four of them.
    #[inline(always)]
    fn enlarged(&self, texels: &Texels, side: usize, planes: &mut [f32]) {
        let Map([[ux, vx, x], [uy, vy, y]]) = self.to_picture();
        let step = 1.0 / side as f64;
        for (at, pixel) in planes.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let [u, v] = [at % side, at / side].map(|i| (i as f64 + 0.5) * step);
            *pixel = texels.between((x + ux * u + vx * v) as f32, (y + uy * u + vy * v) as f32);
        }
    }

    /// The same with so many samples of a pixel along each side. More than four are not worth their
    /// time.
    #[inline(always)]
    fn sampled<const SAMPLES: usize>(&self, texels: &Texels, side: usize, planes: &mut [f32]) {
        let Map([[ux, vx, x], [uy, vy, y]]) = self.to_picture();
        let step = 1.0 / (side * SAMPLES) as f64;
        // Single precision is a hundredth of a pixel at most, and what is asked for most.
        let along = [ux * step, uy * step].map(|v| v as f32);
        let share = 2.0 / (255 * SAMPLES * SAMPLES) as f32;
        let mut sums = vec![Sum::default(); side];
        let mut places = vec![0u32; side * SAMPLES];
        for row in 0..side {
            sums.fill(Sum::default());
            for line in 0..SAMPLES {
                let v = ((row * SAMPLES + line) as f64 + 0.5) * step;
                let start = [x + vx * v + 0.5 * ux * step, y + vy * v + 0.5 * uy * step].map(|v| v as f32);
                // All places of a line before their pixels: they are computed several at a time.
                for (place, sample) in places.iter_mut().zip(0i16..) {
                    let sample = f32::from(sample);
                    *place = texels.place(start[0] + along[0] * sample, start[1] + along[1] * sample);
                }
                for (sum, places) in sums.iter_mut().zip(places.as_chunks::<SAMPLES>().0) {
                    places.iter().for_each(|&place| sum.add(texels.at(place)));
                }
            }
            for (pixel, sum) in planes.as_chunks_mut::<3>().0[row * side..].iter_mut().zip(&sums) {
                let [r, g, b] = sum.channels();
                *pixel = [r as f32 * share - 1.0, g as f32 * share - 1.0, b as f32 * share - 1.0];
            }
        }
    }
}

/// Fills `planes` with a square's pixels, each of at most four by four of the picture's.
// With AVX2, where a processor has it, to the same bits in less than half of the time.
#[multiversion(targets("x86_64+avx2"))]
fn fill(square: &Square, texels: &Texels, side: usize, planes: &mut [f32]) {
    match (square.side / side as f64).ceil() {
        4.0.. => square.sampled::<4>(texels, side, planes),
        3.0.. => square.sampled::<3>(texels, side, planes),
        2.0.. => square.sampled::<2>(texels, side, planes),
        _ => square.enlarged(texels, side, planes),
    }
}

/// A picture's pixels as they are sampled.
pub(super) struct Texels {
    width: u32,
    /// The last column and the last row.
    last: [f32; 2],
    /// Red, green and blue of each pixel, from the lowest byte on.
    rgb: Vec<u32>,
}

impl Texels {
    pub(super) fn of(picture: &Picture) -> Self {
        let rgb = picture.rgb().iter().map(|&[r, g, b]| u32::from_le_bytes([r, g, b, 0])).collect();
        let last = [picture.width(), picture.height()].map(|length| (length - 1) as f32);
        Self { width: picture.width() as u32, last, rgb }
    }

    /// Those of a mask alone, all others black.
    pub(super) fn of_cut_out(picture: &Picture, hand: &Mask) -> Self {
        let mut texels = Self::of(picture);
        let outside = texels.rgb.iter_mut().zip(hand.pixels()).filter(|(_, inside)| **inside == 0);
        outside.for_each(|(texel, _)| *texel = 0);
        texels
    }

    /// Where the pixel around a place is, or that of the border nearest to it.
    #[inline(always)]
    fn place(&self, x: f32, y: f32) -> u32 {
        let [x, y] = [whole(x, self.last[0]), whole(y, self.last[1])];
        y.wrapping_mul(self.width).wrapping_add(x)
    }

    /// The colour at a place between the middles of pixels, -1 to 1.
    fn between(&self, x: f32, y: f32) -> [f32; 3] {
        let [(x, u), (y, v)] = [(x - 0.5, self.last[0]), (y - 0.5, self.last[1])].map(|(place, last)| {
            let low = place.clamp(0.0, last).floor();
            (low, (place - low).clamp(0.0, 1.0))
        });
        let mut sum = [0.0f32; 3];
        for (dx, dy, weight) in [
            (0.0, 0.0, (1.0 - u) * (1.0 - v)),
            (1.0, 0.0, u * (1.0 - v)),
            (0.0, 1.0, (1.0 - u) * v),
            (1.0, 1.0, u * v),
        ] {
            let rgb = self.at(self.place(x + dx, y + dy)).to_le_bytes();
            (0..3).for_each(|i| sum[i] += weight * f32::from(rgb[i]));
        }
        sum.map(|v| v * (2.0 / 255.0) - 1.0)
    }

    fn at(&self, place: u32) -> u32 {
        self.rgb.get(place as usize).copied().unwrap_or_default()
    }
}

/// The whole part of `value`, from 0 to `last`, which is a whole number below 2^22. A cast would do
/// the same, a value at a time.
#[inline(always)]
fn whole(value: f32, last: f32) -> u32 {
    /// From here on, up to twice as much, the last bit of the mantissa counts 1.
    const WHOLE: f32 = 8_388_608.0;
    let value = if value > 0.0 { value } else { 0.0 };
    let value = if value < last { value } else { last };
    let nearest = value + WHOLE;
    let is_above = nearest - WHOLE > value;
    (nearest.to_bits() & 0x007F_FFFF).wrapping_sub(u32::from(is_above))
}

/// A sum of at most 257 pixels.
#[derive(Clone, Copy, Default)]
struct Sum {
    /// Red in the lower half, blue in the upper one.
    red_blue: u32,
    green: u32,
}

impl Sum {
    fn add(&mut self, texel: u32) {
        self.red_blue += texel & 0x00FF_00FF;
        self.green += texel >> 8 & 0xFF;
    }

    fn channels(&self) -> [u32; 3] {
        [self.red_blue & 0xFFFF, self.green, self.red_blue >> 16]
    }
}

/// An affine map of the plane: the rows of its matrix, shifts last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map([[f64; 3]; 2]);

impl Map {
    /// Where a place comes to lie.
    pub fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.0.map(|[across, down, shift]| across * u + down * v + shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_there_and_back() {
        let square = Square { centre: [30.0, 50.0], side: 20.0, turn: 0.7 };
        for place in [[0.0, 0.0], [0.2, 0.9], [1.5, -0.5]] {
            let back = square.from_picture().apply(square.to_picture().apply(place));
            assert!(back.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        // Turned clockwise by a quarter, what was at the left is at the top.
        let quarter = Square { turn: std::f64::consts::FRAC_PI_2, ..square };
        let [u, v] = quarter.from_picture().apply([20.0, 50.0]);
        assert!((u - 0.5).abs() < 1e-12 && v.abs() < 1e-12);
    }

    #[test]
    fn a_square_shows_its_part_and_beyond_the_border_what_lies_at_it() {
        let rgb = (0..40 * 20).map(|at| if at % 40 < 20 { [255, 0, 0] } else { [0, 0, 255] }).collect();
        let picture = Picture::new(40, 20, rgb).unwrap();
        let mut planes = Vec::new();
        Square::around(&picture).planes(&Texels::of(&picture), 8, &mut planes);
        assert_eq!(planes.len(), 8 * 8 * 3);
        assert_eq!(planes[..3], [1.0, -1.0, -1.0]);
        assert_eq!(planes[planes.len() - 3..], [-1.0, -1.0, 1.0]);
    }

    #[test]
    fn the_whole_part_is_that_of_a_cast() {
        let odd =
            [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -0.0, 0.499_999_97, 0.999_999_94, 510.999_97];
        for value in (-2000..40_000).map(|n| n as f32 * 0.0137).chain(odd) {
            assert_eq!(whole(value, 511.0), (value as u32).min(511), "{value}");
        }
    }

    #[test]
    fn an_enlarged_slope_is_even_and_stops_at_the_border() {
        let rgb = (0..20 * 10).map(|at| [at % 20 * 10, at / 20 * 20, 7].map(|v| v as u8)).collect();
        let picture = Picture::new(20, 10, rgb).unwrap();
        let square = Square { centre: [17.0, 5.0], side: 8.0, turn: 0.2 };
        let (side, mut planes) = (24, Vec::new());
        square.planes(&Texels::of(&picture), side, &mut planes);
        let map = square.to_picture();
        for (at, found) in planes.as_chunks::<3>().0.iter().enumerate() {
            let [x, y] = map.apply([at % side, at / side].map(|i| (i as f64 + 0.5) / side as f64));
            let right = [10.0 * (x - 0.5).clamp(0.0, 19.0), 20.0 * (y - 0.5).clamp(0.0, 9.0), 7.0];
            assert!(found.iter().zip(right).all(|(a, b)| (f64::from(*a) - (b / 127.5 - 1.0)).abs() < 1e-3));
        }
    }

    #[test]
    fn a_pixel_is_the_mean_of_its_samples() {
        let rgb =
            (0..90 * 70).map(|at| [at % 90, at / 90, 255 - at % 90 - at / 90].map(|v| v as u8)).collect();
        let picture = Picture::new(90, 70, rgb).unwrap();
        let side = 8;
        for (length, samples) in [(15.0, 2), (20.0, 3), (30.0, 4), (90.0, 4)] {
            let square = Square { centre: [40.0, 30.0], side: length, turn: 0.3 };
            let mut planes = Vec::new();
            square.planes(&Texels::of(&picture), side, &mut planes);
            let map = square.to_picture();
            for (at, found) in planes.as_chunks::<3>().0.iter().enumerate() {
                let mut sum = [0.0; 3];
                for (dx, dy) in (0..samples).flat_map(|dy| (0..samples).map(move |dx| (dx, dy))) {
                    let place = [(at % side * samples + dx, 90), (at / side * samples + dy, 70)];
                    let share = place.map(|(v, _)| (v as f64 + 0.5) / (side * samples) as f64);
                    let [x, y] = map.apply(share).map(|v| v.max(0.0) as usize);
                    let rgb = picture.rgb()[y.min(69) * 90 + x.min(89)];
                    sum = std::array::from_fn(|channel| sum[channel] + f64::from(rgb[channel]));
                }
                let mean = sum.map(|sum| 2.0 * sum / 255.0 / (samples * samples) as f64 - 1.0);
                // In single precision a sample between two pixels may fall into the other one.
                assert!(
                    found.iter().zip(mean).all(|(a, b)| (f64::from(*a) - b).abs() < 0.02),
                    "{length}: {at}"
                );
            }
        }
    }
}
