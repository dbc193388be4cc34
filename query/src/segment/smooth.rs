//! Averages values over a picture's surfaces, and not across its edges.
//!
//! The recursive domain transform of Gastal and Oliveira ("Domain transform for edge-aware image and video
//! processing", SIGGRAPH 2011): an exponential filter along rows and columns, in which a step across an edge counts
//! as a long way. Its cost does not depend on how far it reaches.

use crate::picture::Picture;

/// Passes over rows and columns; each reaches half as far as the one before.
const PASSES: i32 = 2;

/// A filter for values that belong to the pixels of one picture.
pub(super) struct Smooth {
    width: usize,
    /// How far the colour of a pixel is from that of its left neighbour, and from the one above: sums of three
    /// absolute differences; 0 where there is no such neighbour.
    left: Vec<u16>,
    above: Vec<u16>,
    /// For each pass: how much of a neighbour's value a pixel takes, by the difference of their colours.
    feedback: Vec<Vec<f32>>,
}

impl Smooth {
    /// A filter that reaches some `reach` pixels, and at which a sum of colour differences of `edge` doubles the way of
    /// `reach` pixels.
    pub(super) fn new(picture: &Picture, reach: f32, edge: f32) -> Self {
        let (width, rgb) = (picture.width(), picture.rgb());
        let difference =
            |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).map(|(a, b)| u16::from(a.abs_diff(*b))).sum::<u16>();
        let mut left = vec![0; rgb.len()];
        for (row, pixels) in left.chunks_exact_mut(width).zip(rgb.chunks_exact(width)) {
            for (out, pair) in row.iter_mut().skip(1).zip(pixels.windows(2)) {
                *out = difference(&pair[0], &pair[1]);
            }
        }
        let mut above = vec![0; rgb.len()];
        for ((out, here), before) in above.iter_mut().skip(width).zip(rgb.iter().skip(width)).zip(rgb) {
            *out = difference(here, before);
        }
        let feedback = (1..=PASSES)
            .map(|pass| {
                let sigma = reach * 3f32.sqrt() * 2f32.powi(PASSES - pass) / (4f32.powi(PASSES) - 1.0).sqrt();
                let decay = -(2f32.sqrt()) / sigma;
                (0..=3 * 255).map(|step| (decay * (1.0 + reach / edge * step as f32)).exp()).collect()
            })
            .collect();
        Self { width, left, above, feedback }
    }

    /// Filters `values`, one a pixel, in place.
    pub(super) fn apply(&self, values: &mut [f32]) {
        for feedback in &self.feedback {
            let take = |difference: u16| feedback[usize::from(difference)];
            for (row, left) in values.chunks_exact_mut(self.width).zip(self.left.chunks_exact(self.width)) {
                for x in 1..row.len() {
                    row[x] += take(left[x]) * (row[x - 1] - row[x]);
                }
                for x in (1..row.len()).rev() {
                    row[x - 1] += take(left[x]) * (row[x] - row[x - 1]);
                }
            }
            let rows = values.len() / self.width;
            for y in 1..rows {
                let (before, here) = values[(y - 1) * self.width..].split_at_mut(self.width);
                for ((here, before), &above) in here.iter_mut().zip(before).zip(&self.above[y * self.width..])
                {
                    *here += take(above) * (*before - *here);
                }
            }
            for y in (1..rows).rev() {
                let (before, here) = values[(y - 1) * self.width..].split_at_mut(self.width);
                for ((here, before), &above) in here.iter().zip(before).zip(&self.above[y * self.width..]) {
                    *before += take(above) * (*here - *before);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_are_averaged_within_a_surface_and_not_across_its_edge() {
        let rgb = (0..20 * 20).map(|at| if at % 20 < 10 { [200; 3] } else { [40; 3] }).collect();
        let picture = Picture::new(20, 20, rgb).unwrap();
        // Noise of one sign on each side.
        let mut values: Vec<f32> =
            (0..400).map(|at| (if at % 20 < 10 { 1.0 } else { -1.0 }) * (at * 7 % 5) as f32).collect();
        Smooth::new(&picture, 10.0, 60.0).apply(&mut values);
        for (at, &value) in values.iter().enumerate() {
            let expected = if at % 20 < 10 { 2.0 } else { -2.0 };
            assert!((value - expected).abs() < 1.2, "{at}: {value}");
        }
    }

    proptest! {
        #[test]
        fn nothing_leaves_the_range_of_what_was_there(
            (width, height, values) in crate::segment::tests_support::grids(-9.0f32..9.0, 9),
            grey in 0..255u8,
        ) {
            let rgb = (0..values.len()).map(|at| [(at as u8).wrapping_mul(grey); 3]).collect();
            let picture = Picture::new(width, height, rgb).unwrap();
            let mut smooth = values.clone();
            Smooth::new(&picture, 10.0, 60.0).apply(&mut smooth);
            let least = values.iter().copied().fold(f32::INFINITY, f32::min) - 1e-4;
            let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max) + 1e-4;
            prop_assert!(smooth.iter().all(|value| (least..=most).contains(value)));
        }
    }
}
