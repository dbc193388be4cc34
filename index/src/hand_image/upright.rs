//! How a hand lies in its picture: the angle by which all pictures of it can be brought into one
//! position.

use super::HandImage;
use std::f64::consts::{FRAC_PI_2, PI};

/// How far down a hand reaches, in pixels, once its pixels are turned clockwise by `turn` radians:
/// to `lengths` of its breadths below the uppermost one. A pixel at `(x, y)`, right and down, is
/// `sin(turn) x + cos(turn) y` far down then; what is farther down is arm.
pub fn end_of_hand(pixels: impl Iterator<Item = [f64; 2]>, turn: f64, lengths: f64) -> f64 {
    let (sin, cos) = libm::sincos(turn);
    let [left, right, top] = pixels.fold([f64::MAX, f64::MIN, f64::MAX], |[left, right, top], [x, y]| {
        let (across, down) = (cos * x - sin * y, sin * x + cos * y);
        [left.min(across), right.max(across), top.min(down)]
    });
    top + lengths * (right - left + 1.0)
}

impl HandImage {
    /// By how many degrees, clockwise on the picture, the hand is to be [turned](Self::rotated) so
    /// that its long axis stands upright and its thinner end points down: at least -180 and below
    /// 180, in whole tenths. Of a picture that is turned by some angle, it is less by that angle;
    /// of its mirror image, it is the opposite.
    ///
    /// The axis is that of the mask's largest second moment (M.-K. Hu, "Visual pattern recognition
    /// by moment invariants", 1962), the end the one of the longer tail: the sign of the third
    /// moment along the axis. A mask that is about as wide as it is long has no such axis, and one
    /// that is alike at both ends no such end; for those, a small difference can make a large one.
    #[must_use]
    pub fn upright_turn_deg(&self) -> f64 {
        let [xx, xy, yy, xxx, xxy, xyy, yyy] = self.central_moments();
        let axis = 0.5 * libm::atan2(2.0 * xy, xx - yy);
        let (sin, cos) = libm::sincos(axis);
        let skew = xxx * cos * cos * cos
            + 3.0 * xxy * cos * cos * sin
            + 3.0 * xyy * cos * sin * sin
            + yyy * sin * sin * sin;
        let thin_end = if skew < 0.0 { axis + PI } else { axis };
        // Tenths, so that the last bits of the moments hardly ever make another descriptor.
        let turn = ((FRAC_PI_2 - thin_end).to_degrees() * 10.0).round() / 10.0;
        if turn < 180.0 { turn } else { turn - 360.0 }
    }

    /// The hand without what lies further than `lengths` breadths behind its uppermost point once
    /// it is turned by `turn_deg`: of a long arm, about half. The picture itself is not turned.
    #[must_use]
    pub fn without_arm(&self, turn_deg: f64, lengths: f64) -> Self {
        let (sin, cos) = libm::sincos(turn_deg.to_radians());
        let rows = || self.mask.chunks_exact(self.width).enumerate();
        // Turning is linear: of a row, nothing comes to lie beyond both its ends.
        let ends = rows().flat_map(|(y, row)| {
            let ends = [row.iter().position(|v| *v != 0), row.iter().rposition(|v| *v != 0)];
            ends.into_iter().flatten().map(move |x| [x as f64, y as f64])
        });
        let end = end_of_hand(ends, turn_deg.to_radians(), lengths);
        let mut kept = self.mask.clone();
        for (y, row) in kept.chunks_exact_mut(self.width).enumerate() {
            let down = cos * y as f64;
            for (value, x) in row.iter_mut().zip(0u32..) {
                *value &= u8::from(sin * f64::from(x) + down < end);
            }
        }
        Self::crop_any_size(self.width, self.height, &self.pixels, |at| kept[at] != 0)
            .unwrap_or_else(|| self.clone())
    }

    /// The second and third central moments of the mask, x right and y down: xx, xy, yy, xxx, xxy,
    /// xyy, yyy.
    fn central_moments(&self) -> [f64; 7] {
        let inside = || {
            let rows = self.mask.chunks_exact(self.width).zip(0u32..);
            rows.flat_map(|(row, y)| {
                row.iter().zip(0u32..).filter(|(v, _)| **v != 0).map(move |(_, x)| (x, y))
            })
        };
        let (mut count, mut sum_x, mut sum_y) = (0u64, 0u64, 0u64);
        for (x, y) in inside() {
            count += 1;
            sum_x += u64::from(x);
            sum_y += u64::from(y);
        }
        let [mean_x, mean_y] = [sum_x, sum_y].map(|sum| sum as f64 / count.max(1) as f64);
        let mut moments = [0.0; 7];
        for (x, y) in inside() {
            let (x, y) = (f64::from(x) - mean_x, f64::from(y) - mean_y);
            let products = [x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
            moments.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
        moments
    }
}
