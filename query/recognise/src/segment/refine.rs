//! A mask found on a small picture, carried over to the large one with the border where the large
//! picture has it.

use super::Mask;
use super::median::counts3x3;
use crate::picture::Picture;

/// Half the side of the window, in pixels of the small picture, over which the colours on both
/// sides of the border are averaged.
const RADIUS: usize = 3;
const _: () = assert!((2 * RADIUS + 1).pow(2) * 255 <= u16::MAX as usize, "a window's sums must fit");
/// Added to the squared difference of both sides' colours: where they are alike, colour has little
/// say.
const ALIKE: f32 = 200.0;

/// Enlarges `small`, the mask of `shrunk`, to the size of `picture`, whose blocks of `factor`
/// pixels `shrunk` averages.
///
/// A pixel near the border goes to the side whose mean colour near by it is closer to, place being
/// counted as well.
pub(super) fn enlarge(small: &Mask, shrunk: &Picture, picture: &Picture, factor: usize) -> Mask {
    if factor <= 1 {
        return small.clone();
    }
    let (width, height) = (picture.width(), picture.height());
    let (across, down) = (small.width(), small.height());
    let sums = Sums::of(small, shrunk);
    let counts = counts3x3(small);
    let mut inside = vec![0u8; width * height];
    for y in 0..down {
        for x in 0..across {
            let here = small.get(x, y);
            let rows = y * factor..((y + 1) * factor).min(height);
            let columns = x * factor..((x + 1) * factor).min(width);
            // Where all of its neighbours are on a pixel's own side there is no border.
            let is_near = !matches!(counts[y * across + x], 0 | 9);
            let Some(border) = is_near.then(|| sums.around(x, y)).flatten() else {
                if here {
                    rows.for_each(|row| inside[row * width..][columns.clone()].fill(1));
                }
                continue;
            };
            for row in rows {
                for column in columns.clone() {
                    let place = place(small, factor, column, row);
                    let at = row * width + column;
                    inside[at] = u8::from(0.5 * place + 2.0 * border.side(picture.rgb()[at]) >= 0.0);
                }
            }
        }
    }
    Mask::from_inside(width, height, inside)
}

/// Between the small mask's pixels: 1 inside, -1 outside, interpolated bilinearly.
fn place(small: &Mask, factor: usize, column: usize, row: usize) -> f32 {
    let position = |at: usize, length: usize| {
        let exact = ((at as f32 + 0.5) / factor as f32 - 0.5).clamp(0.0, (length - 1) as f32);
        (exact as usize, exact.fract())
    };
    let ((x, fx), (y, fy)) = (position(column, small.width()), position(row, small.height()));
    let value = |x: usize, y: usize| {
        let (x, y) = (x.min(small.width() - 1), y.min(small.height() - 1));
        if small.get(x, y) { 1.0 } else { -1.0 }
    };
    let line = |y: usize| value(x, y) * (1.0 - fx) + value(x + 1, y) * fx;
    line(y) * (1.0 - fy) + line(y + 1) * fy
}

/// The mean colours on both sides of the border near a place.
struct Border {
    hand: [f32; 3],
    other: [f32; 3],
}

impl Border {
    /// Where a colour lies between both sides: towards 0.5 at the hand's, -0.5 at the other's.
    fn side(&self, rgb: [u8; 3]) -> f32 {
        let (mut along, mut length) = (0.0, 0.0);
        for ((hand, other), value) in self.hand.iter().zip(self.other).zip(rgb) {
            let axis = hand - other;
            along += axis * (f32::from(value) - 0.5 * (hand + other));
            length += axis * axis;
        }
        along / (length + ALIKE)
    }
}

/// Sums of colours over rectangles, for all pixels and for those inside the mask (summed-area
/// tables).
struct Sums {
    width: usize,
    height: usize,
    /// (width + 1) x (height + 1) corners: red, green, blue and count of the hand's pixels, then of
    /// all. Each is what is left of a sum once whole multiples of 2^16 are taken away: a window's
    /// own sums are smaller, and are found exactly.
    corners: Vec<[u16; 8]>,
}

impl Sums {
    fn of(mask: &Mask, picture: &Picture) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let stride = width + 1;
        let mut corners = vec![[0u16; 8]; stride * (height + 1)];
        for (y, (row, inside)) in
            picture.rgb().chunks_exact(width).zip(mask.pixels().chunks_exact(width)).enumerate()
        {
            let mut line = [0u16; 8];
            let (above, here) = corners[y * stride..][..2 * stride].split_at_mut(stride);
            let corners = above.iter().zip(here).skip(1);
            for ((&[r, g, b], &inside), (above, here)) in row.iter().zip(inside).zip(corners) {
                let all = [r, g, b, 1].map(u16::from);
                let hand = all.map(|value| value * u16::from(inside));
                let values = [hand, all];
                let values = values.as_flattened();
                line = std::array::from_fn(|channel| line[channel].wrapping_add(values[channel]));
                *here = std::array::from_fn(|channel| above[channel].wrapping_add(line[channel]));
            }
        }
        Self { width, height, corners }
    }

    /// Both sides' mean colours in the window around a pixel; `None` where one side is not in it.
    fn around(&self, x: usize, y: usize) -> Option<Border> {
        let corner = |x: usize, y: usize| self.corners[y * (self.width + 1) + x];
        let (left, right) = (x.saturating_sub(RADIUS), (x + RADIUS + 1).min(self.width));
        let (top, bottom) = (y.saturating_sub(RADIUS), (y + RADIUS + 1).min(self.height));
        let [a, b, c, d] =
            [corner(right, bottom), corner(left, top), corner(left, bottom), corner(right, top)];
        let sum: [u16; 8] = std::array::from_fn(|channel| {
            a[channel].wrapping_add(b[channel]).wrapping_sub(c[channel]).wrapping_sub(d[channel])
        });
        let (inside, all) = (sum[3], sum[7]);
        if inside == 0 || inside == all {
            return None;
        }
        let mean = |total: u16, count: u16| f32::from(total) / f32::from(count);
        Some(Border {
            hand: std::array::from_fn(|channel| mean(sum[channel], inside)),
            other: std::array::from_fn(|channel| mean(sum[channel + 4] - sum[channel], all - inside)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_is_found_to_the_pixel_on_the_large_picture() {
        // A disc whose border falls between the blocks of the small picture.
        let (side, factor) = (96, 4);
        let truth = |at: usize| {
            let (x, y) = ((at % side) as f32 - 45.3, (at / side) as f32 - 50.8);
            x.hypot(y) < 27.0
        };
        let rgb: Vec<[u8; 3]> =
            (0..side * side).map(|at| if truth(at) { [200, 140, 110] } else { [60, 80, 90] }).collect();
        let picture = Picture::new(side, side, rgb).unwrap();
        let shrunk = picture.shrunk(factor);
        let small = Mask::from_values(side / factor, side / factor, shrunk.rgb(), |[r, _, _]| r > 130);
        let expected: Vec<bool> = (0..side * side).map(truth).collect();
        let expected = Mask::from_values(side, side, &expected, |v| v);
        let enlarged = enlarge(&small, &shrunk, &picture, factor);
        assert!(small.resized(side, side).iou(&expected).unwrap() < 0.94);
        assert!(enlarged.iou(&expected).unwrap() > 0.99, "{:?}", enlarged.iou(&expected));
    }

    #[test]
    fn a_picture_of_ragged_size_is_covered_to_its_last_pixel() {
        let picture = Picture::new(7, 5, vec![[9; 3]; 35]).unwrap();
        let shrunk = picture.clone().shrunk_to(4);
        let all = Mask::from_values(4, 3, &[1; 12], |v| v == 1);
        assert_eq!(enlarge(&all, &shrunk, &picture, 2).area(), 35);
    }
}
