//! The 3 x 3 median of a binary picture.

use super::Mask;

/// The majority of each pixel's 3 x 3 neighbourhood; beyond the border the border's own pixel
/// repeats.
///
/// The border repeats, because an arm that leaves the picture must not be eaten there.
pub fn median3x3(mask: &Mask) -> Mask {
    let majority = counts3x3(mask).into_iter().map(|count| u8::from(count >= 5)).collect();
    Mask::from_inside(mask.width(), mask.height(), majority)
}

/// How many pixels are inside of each pixel's 3 x 3 neighbourhood; beyond the border the border's
/// own pixel repeats.
pub(super) fn counts3x3(mask: &Mask) -> Vec<u8> {
    let (width, height) = (mask.width(), mask.height());
    if width == 0 || height == 0 {
        return Vec::new();
    }
    // Sums over columns first: each pixel is then added three times instead of nine.
    let pixels = mask.pixels();
    let mut columns = vec![0u8; width + 2];
    let mut counts = Vec::with_capacity(width * height);
    for y in 0..height {
        let row = |y: usize| &pixels[y * width..(y + 1) * width];
        let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(height - 1)));
        let sums = &mut columns[1..=width];
        for (sum, ((a, b), c)) in sums.iter_mut().zip(above.iter().zip(here).zip(below)) {
            *sum = a + b + c;
        }
        columns[0] = columns[1];
        columns[width + 1] = columns[width];
        let (left, middle, right) = (&columns[..width], &columns[1..=width], &columns[2..]);
        counts
            .extend(left.iter().zip(middle).zip(right).map(|((left, middle), right)| left + middle + right));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(mask: &Mask) -> Mask {
        let (width, height) = (mask.width() as i64, mask.height() as i64);
        let mut out = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let mut values = Vec::new();
                for dy in -1..=1 {
                    for dx in -1..=1 {
                        let (nx, ny) = ((x + dx).clamp(0, width - 1), (y + dy).clamp(0, height - 1));
                        values.push(u8::from(mask.get(nx as usize, ny as usize)));
                    }
                }
                values.sort_unstable();
                out.push(values[4]);
            }
        }
        Mask::from_values(mask.width(), mask.height(), &out, |v| v == 1)
    }

    proptest! {
        #[test]
        fn it_is_the_median_of_nine((width, height, pixels) in crate::segment::tests_support::masks()) {
            let mask = Mask::from_values(width, height, &pixels, |v| v);
            prop_assert_eq!(median3x3(&mask), naive(&mask));
        }
    }
}
