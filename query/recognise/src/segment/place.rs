//! What a pixel's place in the picture says for the hand.

/// How much each pixel's place counts for the hand before anything is known: 1 in the middle,
/// e^-`strength` at the middle of a side.
pub(super) fn centrality(width: usize, height: usize, strength: f32) -> Vec<f32> {
    let axis = |length: usize| -> Vec<f32> {
        let half = length as f32 / 2.0;
        (0..length).map(|at| libm::expf(-strength * ((at as f32 + 0.5 - half) / half).powi(2))).collect()
    };
    let (columns, rows) = (axis(width), axis(height));
    rows.iter().flat_map(|row| columns.iter().map(move |column| row * column)).collect()
}

/// The smallest variance of a hand along an axis, in squared widths or heights of the picture: a
/// speck is no hand.
const LEAST_VARIANCE: f32 = 0.003;

/// Where a hand lies and how far it extends: the mean and the covariance of its pixels, each axis
/// in lengths of the picture's side.
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
        // Moments of columns first: a whole row of numbers is added at once.
        let [mut all, mut by_y, mut by_yy] = [(); 3].map(|()| vec![0f32; width]);
        for (y, row) in weights.chunks_exact(width.max(1)).enumerate() {
            let y = y as f32 / height as f32 - 0.5;
            let columns = all.iter_mut().zip(&mut by_y).zip(&mut by_yy);
            for (((all, by_y), by_yy), &weight) in columns.zip(row) {
                *all += weight;
                *by_y += weight * y;
                *by_yy += weight * y * y;
            }
        }
        let (mut sum, mut x1, mut y1, mut xx, mut xy, mut yy) = (1e-9, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (x, ((all, by_y), by_yy)) in all.into_iter().zip(by_y).zip(by_yy).enumerate() {
            let x = x as f32 / width as f32 - 0.5;
            sum += all;
            x1 += all * x;
            xx += all * x * x;
            y1 += by_y;
            xy += by_y * x;
            yy += by_yy;
        }
        let mean = (x1 / sum, y1 / sum);
        let spread = (
            xx / sum - mean.0 * mean.0 + LEAST_VARIANCE,
            xy / sum - mean.0 * mean.1,
            yy / sum - mean.1 * mean.1 + LEAST_VARIANCE,
        );
        Self { mean, spread }
    }

    /// Writes the squared Mahalanobis distance of every pixel of a picture, row by row, into
    /// `distances`, whatever that held.
    pub(super) fn distances(&self, width: usize, height: usize, distances: &mut Vec<f32>) {
        let (a, b, c) = self.spread;
        let scale = 1.0 / (a * c - b * b).max(1e-9);
        let columns: Vec<f32> = (0..width).map(|x| x as f32 / width as f32 - 0.5 - self.mean.0).collect();
        distances.clear();
        for y in 0..height {
            let dy = y as f32 / height as f32 - 0.5 - self.mean.1;
            distances
                .extend(columns.iter().map(|dx| (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) * scale));
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
        let mut distances = vec![f32::NAN; 3];
        Ellipse::of(width, &weights).distances(width, height, &mut distances);
        assert!((0..width * height).filter(|&at| inside(at)).all(|at| distances[at] < 6.0));
        assert!(distances[(height - 1) * width] > 40.0);
    }

    #[test]
    fn nothing_at_all_makes_a_wide_berth_and_no_nan() {
        let mut distances = Vec::new();
        Ellipse::of(4, &[0.0; 16]).distances(4, 4, &mut distances);
        assert_eq!(distances.len(), 16);
        assert!(distances.iter().all(|distance| distance.is_finite()));
    }
}
