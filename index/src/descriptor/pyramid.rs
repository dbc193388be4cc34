//! The pyramid: `L` levels of cells, level `l` with `2^(L-l)` cells a side, `B` bins a cell. The
//! finest level comes first, each level row by row.

use super::gradient::Field;

/// `(cells a side, first value)` of each level, finest first.
fn levels_of(bins: usize, levels: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut start = 0;
    (0..levels).rev().map(move |exponent| {
        let cells = 1usize << exponent;
        let level = (cells, start);
        start += cells * cells * bins;
        level
    })
}

fn dim(bins: usize, levels: usize) -> usize {
    levels_of(bins, levels).map(|(cells, _)| cells * cells * bins).sum()
}

/// Every pixel in the one cell that it lies in.
pub(super) fn hard(field: &Field, bins: usize, levels: usize) -> Vec<f32> {
    let mut histograms = vec![0.0; dim(bins, levels)];
    let (width, height) = (field.width, field.height);
    for (line, weights) in field.weights.chunks_exact(width).enumerate() {
        let (y, bin) = (line / bins, line % bins);
        for (x, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            for (cells, start) in levels_of(bins, levels) {
                let cell = (y * cells / height) * cells + x * cells / width;
                histograms[start + cell * bins + bin] += weight;
            }
        }
    }
    histograms
}

/// Every pixel shared linearly between the four cells whose centres are nearest; beyond the
/// outermost centres all of it goes to the border cells. Columns of pixels are gathered first,
/// because that is a sum of whole lines, and then each line is shared among its cells: `columns` is
/// scratch for the former.
pub(super) fn soft(field: &Field, bins: usize, levels: usize, columns: &mut Vec<f32>) -> Vec<f32> {
    let mut histograms = vec![0.0; dim(bins, levels)];
    let (width, height) = (field.width, field.height);
    for (cells, start) in levels_of(bins, levels) {
        columns.clear();
        columns.resize(cells * bins * width, 0.0);
        for (y, weights) in field.weights.chunks_exact(bins * width).enumerate() {
            for (cell, share) in nearest_cells(y, height, cells) {
                if share > 0.0 {
                    let sums = &mut columns[cell * bins * width..][..bins * width];
                    for (sum, weight) in sums.iter_mut().zip(weights) {
                        *sum += share * weight;
                    }
                }
            }
        }
        for (line, sums) in columns.chunks_exact(width).enumerate() {
            let (row, bin) = (line / bins, line % bins);
            for (x, &sum) in sums.iter().enumerate() {
                for (column, share) in nearest_cells(x, width, cells) {
                    histograms[start + (row * cells + column) * bins + bin] += share * sum;
                }
            }
        }
    }
    histograms
}

/// The two cells, of `cells` along a side of `length` pixels, that pixel `at` is shared between,
/// and its share in each.
fn nearest_cells(at: usize, length: usize, cells: usize) -> [(usize, f32); 2] {
    let position = (at as f32 + 0.5) * cells as f32 / length as f32 - 0.5;
    let position = position.clamp(0.0, (cells - 1) as f32);
    let first = position as usize;
    let share = position - first as f32;
    [(first, 1.0 - share), ((first + 1).min(cells - 1), share)]
}

/// Makes each cell's histogram sum to 1. A cell without any gradient stays 0.
pub(super) fn normalise_cells(histograms: &mut [f32], bins: usize) {
    histograms.chunks_exact_mut(bins).for_each(normalise);
}

/// Makes each level sum to 1.
pub(super) fn normalise_levels(histograms: &mut [f32], bins: usize, levels: usize) {
    for (cells, start) in levels_of(bins, levels) {
        normalise(&mut histograms[start..start + cells * cells * bins]);
    }
}

fn normalise(values: &mut [f32]) {
    let sum: f32 = values.iter().sum();
    if sum > 0.0 {
        values.iter_mut().for_each(|value| *value /= sum);
    }
}
