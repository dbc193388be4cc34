//! The pixels of a colour picture.

use std::ops::AddAssign;

/// An RGB picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of `width` x `height` pixels, or `None` where `rgb` has another length or a side
    /// is 0.
    pub fn new(width: usize, height: usize, rgb: Vec<[u8; 3]>) -> Option<Self> {
        let fits = width > 0 && height > 0 && width.checked_mul(height) == Some(rgb.len());
        fits.then_some(Self { width, height, rgb })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// `width * height` pixels, red, green, blue in 0..=255.
    pub fn rgb(&self) -> &[[u8; 3]] {
        &self.rgb
    }

    /// The luminance of each pixel (ITU-R BT.601, as JPEG has it), 0..=255.
    pub fn grey(&self) -> Vec<u8> {
        self.rgb
            .iter()
            .map(|&[r, g, b]| {
                let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b);
                ((sum + (1 << 15)) >> 16) as u8
            })
            .collect()
    }

    /// The factor by which the picture must shrink for its longer side to be at most `side`.
    pub fn shrink_factor(&self, side: usize) -> usize {
        self.width.max(self.height).div_ceil(side.max(1)).max(1)
    }

    /// The picture with blocks of pixels averaged, so that no side is longer than `side`.
    pub fn shrunk_to(self, side: usize) -> Self {
        match self.shrink_factor(side) {
            1 => self,
            factor => self.shrunk(factor),
        }
    }

    /// The picture with blocks of `factor` x `factor` pixels averaged; those at the right and lower
    /// border may be smaller.
    pub(crate) fn shrunk(&self, factor: usize) -> Self {
        // Small numbers are added more of them at once.
        let rgb = if factor * usize::from(u8::MAX) <= usize::from(u16::MAX) {
            self.means::<u16>(factor)
        } else {
            self.means::<u32>(factor)
        };
        Self { width: self.width.div_ceil(factor), height: self.height.div_ceil(factor), rgb }
    }

    /// The means of blocks of `factor` x `factor` pixels; `S` has room for a block's sum.
    fn means<S: Copy + Default + From<u8> + AddAssign + Into<u32>>(&self, factor: usize) -> Vec<[u8; 3]> {
        let mut rgb = Vec::with_capacity(self.width.div_ceil(factor) * self.height.div_ceil(factor));
        // Down the columns first: whole rows of numbers are added at once.
        let mut columns = vec![[S::default(); 3]; self.width];
        for rows in self.rgb.chunks(factor * self.width) {
            columns.fill([S::default(); 3]);
            for row in rows.chunks_exact(self.width) {
                for (sum, value) in columns.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
                    *sum += S::from(*value);
                }
            }
            // Cameras' pictures shrink by these factors, and dividing by a constant is many times
            // faster.
            match (factor, rows.len() / self.width) {
                (2, 2) => squares::<2, S>(&columns, &mut rgb),
                (3, 3) => squares::<3, S>(&columns, &mut rgb),
                (4, 4) => squares::<4, S>(&columns, &mut rgb),
                (_, rows) => rgb.extend(columns.chunks(factor).map(|block| mean(block, rows))),
            }
        }
        rgb
    }
}

/// Adds the means of blocks of `SIDE` x `SIDE` pixels, of which `columns` are the columns' sums.
fn squares<const SIDE: usize, S: Copy + Into<u32>>(columns: &[[S; 3]], means: &mut Vec<[u8; 3]>) {
    let (blocks, rest) = columns.as_chunks::<SIDE>();
    means.extend(blocks.iter().map(|block| mean(block, SIDE)));
    means.extend(rest.chunks(SIDE).map(|block| mean(block, SIDE)));
}

/// The mean of a block, of whose columns of `rows` pixels these are the sums.
#[inline(always)]
fn mean<S: Copy + Into<u32>>(block: &[[S; 3]], rows: usize) -> [u8; 3] {
    let count = (rows * block.len()) as u32;
    // Loops, here and in other hot places: `map` of arrays is not always inlined.
    let mut mean = [0; 3];
    for (channel, mean) in mean.iter_mut().enumerate() {
        let mut total = count / 2;
        for column in block {
            let sum: u32 = column[channel].into();
            total += sum;
        }
        *mean = (total / count) as u8;
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_refuses_a_buffer_of_another_size() {
        assert!(Picture::new(2, 2, vec![[0; 3]; 3]).is_none());
        assert!(Picture::new(0, 2, Vec::new()).is_none());
        assert!(Picture::new(usize::MAX, 2, Vec::new()).is_none());
    }

    #[test]
    fn grey_keeps_white_and_black_and_weighs_green_most() {
        let picture = Picture::new(4, 1, vec![[0; 3], [255; 3], [255, 0, 0], [0, 255, 0]]).unwrap();
        assert_eq!(picture.grey(), [0, 255, 76, 150]);
    }

    #[test]
    fn shrinking_averages_blocks_and_keeps_ragged_edges() {
        let picture = Picture::new(3, 1, vec![[0; 3], [100; 3], [7; 3]]).unwrap();
        let small = picture.shrunk_to(2);
        assert_eq!((small.width(), small.height()), (2, 1));
        assert_eq!(small.rgb(), [[50; 3], [7; 3]]);
    }

    #[test]
    fn shrinking_by_any_factor_rounds_the_mean_of_each_block() {
        let (width, height) = (23usize, 17usize);
        let rgb: Vec<[u8; 3]> =
            (0..width * height).map(|at| [at * 7, at * at, at / 3].map(|v| v as u8)).collect();
        let picture = Picture::new(width, height, rgb.clone()).unwrap();
        for factor in [1, 2, 3, 4, 5, 6, 300] {
            let small = picture.shrunk(factor);
            for (at, found) in small.rgb().iter().enumerate() {
                let (left, top) = (at % small.width() * factor, at / small.width() * factor);
                let block: Vec<[u8; 3]> = (top..(top + factor).min(height))
                    .flat_map(|y| (left..(left + factor).min(width)).map(move |x| y * width + x))
                    .map(|place| rgb[place])
                    .collect();
                let mean = std::array::from_fn(|channel| {
                    let sum: usize = block.iter().map(|pixel| usize::from(pixel[channel])).sum();
                    ((sum + block.len() / 2) / block.len()) as u8
                });
                assert_eq!(*found, mean, "{factor}: {at}");
            }
        }
    }
}
