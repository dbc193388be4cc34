//! Where a hand is in its picture.

use grasp_recognise::picture::{Picture, WORKING_SIDE};
use grasp_recognise::segment::Mask;

/// A picture as it came, before it was shrunk to be worked on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Original {
    /// Pixels in a row, and rows.
    pub(crate) size: [usize; 2],
    /// Its pixels for one of the mask, across and down.
    factor: usize,
}

impl Original {
    /// Of a picture that was not shrunk yet.
    pub(crate) fn of(picture: &Picture) -> Self {
        let size = [picture.width(), picture.height()];
        Self { size, factor: picture.shrink_factor(WORKING_SIDE) }
    }
}

/// The least upright rectangle around a hand, in pixels of the picture as it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    /// Its middle, from the left and from the top.
    pub(crate) centre: [f64; 2],
    /// Across and down.
    pub(crate) size: [f64; 2],
}

impl Rectangle {
    /// Around a mask of the shrunk picture; `None` where the mask is empty.
    pub(crate) fn of(mask: &Mask, Original { size, factor }: Original) -> Option<Self> {
        let (width, height) = (mask.width(), mask.height());
        let is_column = |x: &usize| (0..height).any(|y| mask.get(*x, y));
        let is_row = |y: &usize| (0..width).any(|x| mask.get(x, *y));
        let (left, right) = ((0..width).find(is_column)?, (0..width).rfind(is_column)?);
        let (top, bottom) = ((0..height).find(is_row)?, (0..height).rfind(is_row)?);
        let along = |first: usize, last: usize, side: usize| {
            // The last block of pixels may be smaller.
            let (first, end) = ((first * factor) as f64, ((last + 1) * factor).min(side) as f64);
            (0.5 * (first + end), end - first)
        };
        let (x, across) = along(left, right, size[0]);
        let (y, down) = along(top, bottom, size[1]);
        Some(Self { centre: [x, y], size: [across, down] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_is_of_the_picture_as_it_came() {
        let picture = Picture::new(1025, 30, vec![[0; 3]; 1025 * 30]).unwrap();
        let original = Original::of(&picture);
        let small = picture.shrunk_to(WORKING_SIDE);
        let (width, height) = (small.width(), small.height());
        let mask = |inside: &[(usize, usize)]| {
            let places: Vec<(usize, usize)> =
                (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
            Mask::from_values(width, height, &places, |place| inside.contains(&place))
        };
        let of = |inside: &[(usize, usize)]| Rectangle::of(&mask(inside), original);
        assert_eq!(of(&[(1, 2), (2, 4)]), Some(Rectangle { centre: [6.0, 10.5], size: [6.0, 9.0] }));
        // The last column is of two pixels.
        assert_eq!(of(&[(width - 1, 0)]), Some(Rectangle { centre: [1024.0, 1.5], size: [2.0, 3.0] }));
        assert_eq!(of(&[]), None);
    }
}
