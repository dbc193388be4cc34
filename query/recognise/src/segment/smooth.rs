//! Averages values over a picture's surfaces, and not across its edges.
//!
//! The recursive domain transform of Gastal and Oliveira ("Domain transform for edge-aware image
//! and video processing", SIGGRAPH 2011): an exponential filter along rows and columns, in which a
//! step across an edge counts as a long way. Its cost does not depend on how far it reaches.

use crate::picture::Picture;

/// Passes over rows and columns; each reaches half as far as the one before.
const PASSES: i32 = 2;

/// A filter for values that belong to the pixels of one picture.
pub(super) struct Smooth {
    width: usize,
    height: usize,
    passes: Vec<Pass>,
}

/// How much of a neighbour's value each pixel takes in one pass, 0..1.
struct Pass {
    /// Of the neighbour above: row by row, from the second row on.
    above: Vec<f32>,
    /// Of the neighbour to the left: column by column, from the second column on.
    left: Vec<f32>,
}

impl Smooth {
    /// A filter that reaches some `reach` pixels, and at which a sum of colour differences of
    /// `edge` doubles the way of `reach` pixels.
    pub(super) fn new(picture: &Picture, reach: f32, edge: f32) -> Self {
        let (width, height, rgb) = (picture.width(), picture.height(), picture.rgb());
        let difference = |a: &[u8; 3], b: &[u8; 3]| {
            a.iter().zip(b).map(|(a, b)| usize::from(a.abs_diff(*b))).sum::<usize>()
        };
        let above: Vec<usize> =
            rgb.iter().skip(width).zip(rgb).map(|(here, above)| difference(here, above)).collect();
        let mut left = Vec::with_capacity(rgb.len());
        for x in 1..width {
            let column = rgb.iter().skip(x).step_by(width).zip(rgb.iter().skip(x - 1).step_by(width));
            left.extend(column.map(|(here, left)| difference(here, left)));
        }
        let passes = (1..=PASSES)
            .map(|pass| {
                let share = 3f32.sqrt() * 2f32.powi(PASSES - pass) / (4f32.powi(PASSES) - 1.0).sqrt();
                let decay = -(2f32.sqrt()) / (reach * share);
                let by_difference: Vec<f32> = (0..=3 * 255)
                    .map(|step| libm::expf(decay * (1.0 + reach / edge * step as f32)))
                    .collect();
                let feedback = |steps: &[usize]| steps.iter().map(|&step| by_difference[step]).collect();
                Pass { above: feedback(&above), left: feedback(&left) }
            })
            .collect();
        Self { width, height, passes }
    }

    /// Filters `values`, one a pixel, in place. `turned` is memory that it works in.
    pub(super) fn apply(&self, values: &mut [f32], turned: &mut Vec<f32>) {
        // Along rows each value waits for the one before; along columns a whole row goes at once.
        // So rows are made columns.
        turned.resize(values.len(), 0.0);
        for pass in &self.passes {
            transpose(self.width, values, turned);
            along_columns(self.height, turned, &pass.left);
            transpose(self.height, turned, values);
            along_columns(self.width, values, &pass.above);
        }
    }
}

/// Turns rows of `width` values into columns.
fn transpose(width: usize, from: &[f32], to: &mut [f32]) {
    /// Rows at a time: a line of the cache is then touched once for so many values.
    const ROWS: usize = 8;
    let height = from.len() / width;
    for (first, rows) in (0..).step_by(ROWS).zip(from.chunks(ROWS * width)) {
        if rows.len() == ROWS * width {
            let lines: [&[f32]; ROWS] = std::array::from_fn(|line| &rows[line * width..][..width]);
            for (x, column) in to.chunks_exact_mut(height).enumerate() {
                let values: [f32; ROWS] = std::array::from_fn(|line| lines[line][x]);
                column[first..][..ROWS].copy_from_slice(&values);
            }
        } else {
            for (y, row) in (first..).zip(rows.chunks_exact(width)) {
                row.iter().enumerate().for_each(|(x, value)| to[x * height + y] = *value);
            }
        }
    }
}

/// The exponential filter down and up the columns of rows of `width` values.
fn along_columns(width: usize, values: &mut [f32], feedback: &[f32]) {
    for (y, feedback) in feedback.chunks_exact(width).enumerate() {
        let (before, here) = values[y * width..][..2 * width].split_at_mut(width);
        for ((here, before), feedback) in here.iter_mut().zip(before).zip(feedback) {
            *here += feedback * (*before - *here);
        }
    }
    for (y, feedback) in feedback.chunks_exact(width).enumerate().rev() {
        let (before, here) = values[y * width..][..2 * width].split_at_mut(width);
        for ((here, before), feedback) in here.iter().zip(before).zip(feedback) {
            *before += feedback * (*here - *before);
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
        Smooth::new(&picture, 10.0, 60.0).apply(&mut values, &mut Vec::new());
        for (at, &value) in values.iter().enumerate() {
            let expected = if at % 20 < 10 { 2.0 } else { -2.0 };
            assert!((value - expected).abs() < 1.2, "{at}: {value}");
        }
    }

    #[test]
    fn a_transposed_picture_has_each_value_in_its_place() {
        for (width, height) in [(1, 1), (8, 8), (7, 20), (33, 17), (24, 9)] {
            let from: Vec<f32> = (0..width * height).map(|at| at as f32).collect();
            let mut to = vec![-1.0; from.len()];
            transpose(width, &from, &mut to);
            for (at, value) in to.iter().enumerate() {
                assert_eq!(*value, from[at % height * width + at / height], "{width} x {height}: {at}");
            }
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
            Smooth::new(&picture, 10.0, 60.0).apply(&mut smooth, &mut Vec::new());
            let least = values.iter().copied().fold(f32::INFINITY, f32::min) - 1e-4;
            let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max) + 1e-4;
            prop_assert!(smooth.iter().all(|value| (least..=most).contains(value)));
        }
    }
}
