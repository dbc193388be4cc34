//! The pixels of a colour picture.

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
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let mut rgb = Vec::with_capacity(width * height);
        // Down the columns first: whole rows of numbers are added at once.
        let mut columns = vec![[0u32; 3]; self.width];
        for rows in self.rgb.chunks(factor * self.width) {
            columns.fill([0; 3]);
            for row in rows.chunks_exact(self.width) {
                for (sum, value) in columns.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
                    *sum += u32::from(*value);
                }
            }
            let rows = rows.len() / self.width;
            rgb.extend(columns.chunks(factor).map(|block| {
                let count = (rows * block.len()) as u32;
                let sum = block.iter().fold([0; 3], |[r, g, b], add| [r + add[0], g + add[1], b + add[2]]);
                sum.map(|total| ((total + count / 2) / count) as u8)
            }));
        }
        Self { width, height, rgb }
    }
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
}
