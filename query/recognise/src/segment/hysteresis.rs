//! From sure pixels to the likely ones that touch them.

use super::Mask;

/// Pixels whose value is at least `likely` and that are 8-connected, through such pixels, to one of
/// at least `sure`.
///
/// `values` holds `width * height` numbers; missing ones count as outside.
pub fn grow(width: usize, height: usize, values: &[f32], sure: f32, likely: f32) -> Mask {
    let is_likely = |index: usize| values.get(index).is_some_and(|&value| value >= likely);
    let mut inside = vec![0u8; width * height];
    let mut open: Vec<usize> = Vec::new();
    for (index, mark) in inside.iter_mut().enumerate() {
        if is_likely(index) && values[index] >= sure {
            *mark = 1;
            open.push(index);
        }
    }
    while let Some(index) = open.pop() {
        let (x, y) = (index % width, index / width);
        for ny in y.saturating_sub(1)..=(y + 1).min(height - 1) {
            for nx in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                let neighbour = ny * width + nx;
                if inside[neighbour] == 0 && is_likely(neighbour) {
                    inside[neighbour] = 1;
                    open.push(neighbour);
                }
            }
        }
    }
    Mask::from_values(width, height, &inside, |v| v == 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Repeats whole passes over the picture until nothing changes.
    fn naive(width: usize, height: usize, values: &[f32], sure: f32, likely: f32) -> Mask {
        let mut inside: Vec<bool> = values.iter().map(|&v| v >= sure && v >= likely).collect();
        loop {
            let mut next = inside.clone();
            for (index, mark) in next.iter_mut().enumerate() {
                let (x, y) = ((index % width) as i64, (index / width) as i64);
                let touches = (0..width * height).any(|other| {
                    let (ox, oy) = ((other % width) as i64, (other / width) as i64);
                    inside[other] && (ox - x).abs() <= 1 && (oy - y).abs() <= 1
                });
                *mark |= touches && values[index] >= likely;
            }
            if next == inside {
                return Mask::from_values(width, height, &inside, |v| v);
            }
            inside = next;
        }
    }

    proptest! {
        #[test]
        fn it_agrees_with_repeated_passes(
            (width, height, values) in crate::segment::tests_support::grids(0..4i8, 9),
            likely in 0..4i8,
            sure in 0..5i8,
        ) {
            let values: Vec<f32> = values.into_iter().map(f32::from).collect();
            let (sure, likely) = (f32::from(sure), f32::from(likely));
            prop_assert_eq!(
                grow(width, height, &values, sure, likely),
                naive(width, height, &values, sure, likely)
            );
        }
    }

    #[test]
    fn likely_pixels_alone_start_nothing() {
        assert_eq!(grow(3, 1, &[1.0, 1.0, 1.0], 2.0, 0.5).area(), 0);
        assert_eq!(grow(3, 1, &[1.0, 1.0, 2.0], 2.0, 0.5).area(), 3);
    }
}
