//! What a pixel's place in the picture says for the hand.

/// How much each pixel's place counts for the hand before anything is known: 1 in the middle, e^-`strength` at the middle
/// of a side.
pub(super) fn centrality(width: usize, height: usize, strength: f32) -> Vec<f32> {
    let axis = |length: usize| -> Vec<f32> {
        let half = length as f32 / 2.0;
        (0..length).map(|at| (-strength * ((at as f32 + 0.5 - half) / half).powi(2)).exp()).collect()
    };
    let (columns, rows) = (axis(width), axis(height));
    rows.iter().flat_map(|row| columns.iter().map(move |column| row * column)).collect()
}

/// The smallest variance of a hand along an axis, in squared widths or heights of the picture: a speck is no hand.
const LEAST_VARIANCE: f32 = 0.003;

/// Where a hand lies and how far it extends: the mean and the covariance of its pixels, each axis in lengths of the picture's side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    mean: (f32, f32),
    /// Variance along x, covariance, variance along y.
    spread: (f32, f32, f32),
}

impl Ellipse {
    /// The ellipse of pixels that count by `weights`, `width` a row.
    pub(super) fn of(width: usize, weights: &[f32]) -> Self {
        let height = weights.len() / width.max(1);
        // Moments by row: one multiplication of a row's sums serves all its pixels.
        let (mut sum, mut x1, mut y1, mut xx, mut xy, mut yy) = (1e-9, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (y, row) in weights.chunks_exact(width.max(1)).enumerate() {
            let y = y as f32 / height as f32 - 0.5;
            let (mut row_sum, mut row_x, mut row_xx) = (0.0, 0.0, 0.0);
            for (x, &weight) in row.iter().enumerate() {
                let x = x as f32 / width as f32 - 0.5;
                row_sum += weight;
                row_x += weight * x;
                row_xx += weight * x * x;
            }
            sum += row_sum;
            x1 += row_x;
            xx += row_xx;
            y1 += row_sum * y;
            xy += row_x * y;
            yy += row_sum * y * y;
        }
        let mean = (x1 / sum, y1 / sum);
        let spread = (
            xx / sum - mean.0 * mean.0 + LEAST_VARIANCE,
            xy / sum - mean.0 * mean.1,
            yy / sum - mean.1 * mean.1 + LEAST_VARIANCE,
        );
        Self { mean, spread }
    }

    /// Calls `each` with the squared Mahalanobis distance of every pixel of a picture, row by row.
    pub(super) fn distances(&self, width: usize, height: usize, mut each: impl FnMut(usize, f32)) {
        let (a, b, c) = self.spread;
        let scale = 1.0 / (a * c - b * b).max(1e-9);
        for y in 0..height {
            let dy = y as f32 / height as f32 - 0.5 - self.mean.1;
            for x in 0..width {
                let dx = x as f32 / width as f32 - 0.5 - self.mean.0;
                each(y * width + x, (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) * scale);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_counts_most() {
        let weights = centrality(5, 3, 3.0);
        assert_eq!(weights[7], 1.0);
        assert!(weights[5] < weights[6] && weights[2] < weights[7] && weights[0] < weights[2]);
    }

    #[test]
    fn an_ellipse_lies_where_its_pixels_do() {
        let (width, height) = (40, 20);
        let inside = |at: usize| (24..36).contains(&(at % width)) && (4..8).contains(&(at / width));
        let weights: Vec<f32> = (0..width * height).map(|at| f32::from(u8::from(inside(at)))).collect();
        let mut farthest_inside = 0f32;
        let mut at_far_corner = 0f32;
        Ellipse::of(width, &weights).distances(width, height, |at, distance| {
            if inside(at) {
                farthest_inside = farthest_inside.max(distance);
            }
            if at == (height - 1) * width {
                at_far_corner = distance;
            }
        });
        assert!(farthest_inside < 6.0, "{farthest_inside}");
        assert!(at_far_corner > 40.0, "{at_far_corner}");
    }

    #[test]
    fn nothing_at_all_makes_a_wide_berth_and_no_nan() {
        Ellipse::of(4, &[0.0; 16]).distances(4, 4, |_, distance| assert!(distance.is_finite()));
    }
}
