//! A binary picture: which pixels are inside.

/// A binary picture, row by row from the top; each pixel is 1 inside and 0 outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    width: usize,
    height: usize,
    inside: Vec<u8>,
}

/// Why a mask does not fit.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum MaskError {
    /// The mask belongs to a picture of another size.
    #[error(
        "the mask has {mask_width} x {mask_height} pixels, its picture {width} x {height}: they must agree"
    )]
    SizeMismatch {
        /// The mask's pixels in a row.
        mask_width: usize,
        /// The mask's rows.
        mask_height: usize,
        /// The picture's pixels in a row.
        width: usize,
        /// The picture's rows.
        height: usize,
    },
}

impl Mask {
    /// A mask that is inside where `test` says so of each of `values` (`width * height` of them;
    /// missing ones are outside).
    pub fn from_values<T: Copy>(width: usize, height: usize, values: &[T], test: impl Fn(T) -> bool) -> Self {
        let mut inside: Vec<u8> =
            values.iter().take(width * height).map(|&value| u8::from(test(value))).collect();
        inside.resize(width * height, 0);
        Self { width, height, inside }
    }

    /// A mask of `width * height` values, each 1 inside and 0 outside.
    pub(super) fn from_inside(width: usize, height: usize, inside: Vec<u8>) -> Self {
        debug_assert!(inside.len() == width * height && inside.iter().all(|&value| value <= 1));
        Self { width, height, inside }
    }

    /// A mask from a grey picture: inside where the value is 128 or more.
    pub fn from_grey(width: usize, height: usize, grey: &[u8]) -> Self {
        Self::from_values(width, height, grey, |value| value >= 128)
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// `width * height` values, 1 inside and 0 outside.
    pub fn pixels(&self) -> &[u8] {
        &self.inside
    }

    /// Whether the pixel in column `x` of row `y` is inside; nothing beyond the border is.
    pub fn get(&self, x: usize, y: usize) -> bool {
        x < self.width && y < self.height && self.inside[y * self.width + x] != 0
    }

    /// The number of pixels inside.
    pub fn area(&self) -> usize {
        // As many at once as a byte can count.
        self.inside.chunks(255).map(|values| usize::from(values.iter().sum::<u8>())).sum()
    }

    /// How many pixels of the picture's top, bottom, left and right side are inside.
    pub fn on_sides(&self) -> [usize; 4] {
        let row = |y: usize| (0..self.width).filter(|&x| self.get(x, y)).count();
        let column = |x: usize| (0..self.height).filter(|&y| self.get(x, y)).count();
        let (right, bottom) = (self.width.saturating_sub(1), self.height.saturating_sub(1));
        [row(0), row(bottom), column(0), column(right)]
    }

    /// What is inside both masks; pixels that `other` lacks are outside.
    pub fn and(&self, other: &Self) -> Self {
        let mut inside = self.inside.clone();
        let others = other.inside.iter().copied().chain(std::iter::repeat(0));
        for (mine, theirs) in inside.iter_mut().zip(others) {
            *mine &= theirs;
        }
        Self { inside, ..*self }
    }

    /// The same mask at another size, each pixel taken from the nearest one.
    pub fn resized(&self, width: usize, height: usize) -> Self {
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        let mut inside = Vec::with_capacity(width * height);
        for y in 0..height {
            let from_y = (2 * y + 1) * self.height / (2 * height);
            for x in 0..width {
                let from_x = (2 * x + 1) * self.width / (2 * width);
                inside.push(u8::from(self.get(from_x, from_y)));
            }
        }
        Self { width, height, inside }
    }

    /// Checks that the mask has the size of its picture.
    ///
    /// # Errors
    /// [`MaskError::SizeMismatch`] where it has not.
    pub fn check_size(&self, width: usize, height: usize) -> Result<(), MaskError> {
        if (self.width, self.height) == (width, height) {
            return Ok(());
        }
        Err(MaskError::SizeMismatch { mask_width: self.width, mask_height: self.height, width, height })
    }

    /// Intersection over union with a mask of the same size; 1 where both are empty, `None` where
    /// sizes differ.
    pub fn iou(&self, other: &Self) -> Option<f64> {
        other.check_size(self.width, self.height).ok()?;
        let (mut both, mut either) = (0usize, 0usize);
        for (&a, &b) in self.inside.iter().zip(&other.inside) {
            both += usize::from(a & b);
            either += usize::from(a | b);
        }
        Some(if either == 0 { 1.0 } else { both as f64 / either as f64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iou_counts_shared_over_all() {
        let a = Mask::from_values(4, 1, &[1, 1, 0, 0], |v| v == 1);
        let b = Mask::from_values(4, 1, &[0, 1, 1, 0], |v| v == 1);
        assert_eq!(a.iou(&b), Some(1.0 / 3.0));
        assert_eq!(a.iou(&Mask::from_grey(2, 2, &[0; 4])), None);
        let nothing = Mask::from_grey(4, 1, &[0; 4]);
        assert_eq!(nothing.iou(&nothing), Some(1.0));
    }

    #[test]
    fn resizing_there_and_back_keeps_the_mask() {
        let mask = Mask::from_values(3, 2, &[1, 0, 1, 0, 1, 0], |v| v == 1);
        assert_eq!(mask.resized(9, 4).resized(3, 2), mask);
    }
}
