//! A square part of a picture, turned, as the network's input.

use crate::picture::Picture;

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

/// Samples of a pixel along each side, at most: more than that are not worth their time.
const MOST_SAMPLES: f64 = 4.0;

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
    pub(super) fn planes(&self, picture: &Picture, side: usize, planes: &mut Vec<f32>) {
        let samples = (self.side / side as f64).ceil().clamp(1.0, MOST_SAMPLES) as usize;
        let Map([[ux, vx, x], [uy, vy, y]]) = self.to_picture();
        let step = 1.0 / (side * samples) as f64;
        // Single precision is a hundredth of a pixel at most, and what is asked for most.
        let along = [ux * step, uy * step].map(|v| v as f32);
        let [last_x, last_y] = [picture.width() - 1, picture.height() - 1];
        let (width, rgb) = (picture.width(), picture.rgb());
        let share = 2.0 / (255 * samples * samples) as f32;
        let mut sums = vec![[0u32; 3]; side];
        planes.clear();
        for row in 0..side {
            sums.fill([0; 3]);
            for line in 0..samples {
                let v = ((row * samples + line) as f64 + 0.5) * step;
                let start = [x + vx * v + 0.5 * ux * step, y + vy * v + 0.5 * uy * step].map(|v| v as f32);
                for (column, sum) in sums.iter_mut().enumerate() {
                    for sample in column * samples..(column + 1) * samples {
                        // Casting saturates: what is left of the picture or above it is at its
                        // border.
                        let px = (start[0] + along[0] * sample as f32) as usize;
                        let py = (start[1] + along[1] * sample as f32) as usize;
                        if let Some(rgb) = rgb.get(py.min(last_y) * width + px.min(last_x)) {
                            sum.iter_mut().zip(rgb).for_each(|(sum, value)| *sum += u32::from(*value));
                        }
                    }
                }
            }
            planes.extend(sums.iter().flatten().map(|sum| *sum as f32 * share - 1.0));
        }
    }
}

/// An affine map of the plane: the rows of its matrix, shifts last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map([[f64; 3]; 2]);

impl Map {
    /// Where a place comes to lie.
    pub fn of(&self, [u, v]: [f64; 2]) -> [f64; 2] {
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
            let back = square.from_picture().of(square.to_picture().of(place));
            assert!(back.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        // Turned clockwise by a quarter, what was at the left is at the top.
        let quarter = Square { turn: std::f64::consts::FRAC_PI_2, ..square };
        let [u, v] = quarter.from_picture().of([20.0, 50.0]);
        assert!((u - 0.5).abs() < 1e-12 && v.abs() < 1e-12);
    }

    #[test]
    fn a_square_shows_its_part_and_beyond_the_border_what_lies_at_it() {
        let rgb = (0..40 * 20).map(|at| if at % 40 < 20 { [255, 0, 0] } else { [0, 0, 255] }).collect();
        let picture = Picture::new(40, 20, rgb).unwrap();
        let mut planes = Vec::new();
        Square::around(&picture).planes(&picture, 8, &mut planes);
        assert_eq!(planes.len(), 8 * 8 * 3);
        assert_eq!(planes[..3], [1.0, -1.0, -1.0]);
        assert_eq!(planes[planes.len() - 3..], [-1.0, -1.0, 1.0]);
    }
}
