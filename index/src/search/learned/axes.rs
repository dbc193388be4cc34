//! The principal axes of the data: the frame in which vectors are quantised.
//!
//! Codes of four bits are too few for the first axes, of which the coordinates vary most, in a unit
//! that the last ones need. So where entries have such codes the axes are turned at random among
//! themselves ([`FittedAxes::mix`]): then all coordinates vary about alike.

use crate::search::blocks::MAX_AXES;
use crate::search::rows::Rows;
use crate::search::simd::Simd;
use nalgebra::{DMatrix, SymmetricEigen};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Rows that the axes are fitted to.
const SAMPLE: usize = 20_000;
/// Of the turn of the axes among themselves, which is the same for every index.
const SEED: u64 = 7;
/// The share of the variance that the axes must hold where the best are measured exactly in the
/// end: what the rest adds to a distance comes in then, and the bytes of more axes cost more time
/// than they save.
const VARIANCE: f64 = 0.96;
/// The same where entries are known by their codes alone.
const VARIANCE_OF_ALL: f64 = 0.995;
/// Fewer axes than that save little of a scan, and what they leave out is then made good by
/// scanning and measuring more (docs/search.md).
const FEWEST_AXES: usize = 64;
/// More axes than that make a scan slower than the exact distances that they save.
const WANTED_AXES: usize = 256;

/// Principal axes as they lie in the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<'a> {
    /// P.
    pub(crate) count: usize,
    /// `D + 1` rows of P: what each value of a vector adds to each coordinate, and last the
    /// coordinates of the zero vector.
    pub(crate) projection: &'a [f32],
}

impl Axes<'_> {
    /// The coordinates of `vector`.
    pub(crate) fn project(&self, simd: Simd, vector: &[f32], coordinates: &mut [f32]) {
        let at = self.projection.len().saturating_sub(self.count);
        let (matrix, offset) = self.projection.split_at(at);
        simd.project(matrix, offset, vector, coordinates);
    }
}

/// Axes on their way into a file.
#[derive(Clone, Debug)]
pub(crate) struct FittedAxes {
    pub(crate) count: usize,
    pub(crate) projection: Vec<f32>,
}

impl FittedAxes {
    /// Turns the axes at random: they span what they did, and distances stay.
    pub(crate) fn mix(self) -> Self {
        let count = self.count;
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        // The sum of four uniform values is normal enough.
        let mut draw = || -> f64 { (0..4).map(|_| rng.random_range(-1.0..1.0f64)).sum() };
        let turn = DMatrix::from_fn(count, count, |_, _| draw()).qr().q();
        let rows = self.projection.chunks_exact(count.max(1)).flat_map(|row| {
            (0..count).map(|axis| {
                let column = turn.column(axis);
                let sum: f64 = row.iter().zip(&column).map(|(&value, turn)| f64::from(value) * turn).sum();
                sum as f32
            })
        });
        Self { count, projection: rows.collect() }
    }

    pub(crate) fn as_axes(&self) -> Axes<'_> {
        Axes { count: self.count, projection: &self.projection }
    }
}

/// Every `step`-th row, so that about `sample` are taken.
pub(crate) fn sample<'a>(rows: Rows<'a>, sample: usize) -> impl Iterator<Item = (u32, &'a [f32])> + Clone {
    let step = rows.len().div_ceil(sample.max(1)).max(1);
    (0..rows.len() as u32).step_by(step).filter_map(move |id| Some((id, rows.get(id)?)))
}

/// The axes in which the rows vary most: as many as hold the wanted share of the variance, and then
/// up to a multiple of 16 (of 4 where that is all there are). `keeps_descriptors`: whether distances
/// are measured exactly in the end.
pub(crate) fn fit(rows: Rows<'_>, keeps_descriptors: bool) -> FittedAxes {
    let dim = rows.dim;
    // Copied, for they are read once for each value: where they lie on a disk, few of their pages
    // may stay in memory.
    let sampled: Vec<f32> = sample(rows, SAMPLE).flat_map(|(_, row)| row).copied().collect();
    let sampled: Vec<&[f32]> = sampled.chunks_exact(dim.max(1)).collect();
    let mean = mean(&sampled, dim);
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(covariance(&sampled, &mean));
    let mut order: Vec<usize> = (0..dim).collect();
    order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
    let total: f64 = eigenvalues.iter().map(|value| value.max(0.0)).sum();
    let wanted = if keeps_descriptors { VARIANCE } else { VARIANCE_OF_ALL };
    let mut held = 0.0;
    let enough = order.iter().position(|&at| {
        held += eigenvalues[at].max(0.0);
        held >= wanted * total
    });
    let enough = enough.map_or(dim, |at| at + 1).next_multiple_of(16);
    let count = enough.max(FEWEST_AXES).min(dim.next_multiple_of(4)).min(WANTED_AXES.min(MAX_AXES));
    let mut projection = vec![0.0; (dim + 1) * count];
    for (axis, &at) in order.iter().take(count).enumerate() {
        let direction = eigenvectors.column(at);
        // An eigenvector's sign means nothing; fixing it keeps the file the same.
        let largest = direction.iter().copied().fold(0.0f64, |a, b| if b.abs() > a.abs() { b } else { a });
        let sign = if largest < 0.0 { -1.0 } else { 1.0 };
        let mut offset = 0.0;
        for value in 0..dim {
            let factor = sign * direction[value];
            projection[value * count + axis] = factor as f32;
            offset -= factor * mean[value];
        }
        projection[dim * count + axis] = offset as f32;
    }
    FittedAxes { count, projection }
}

fn mean(rows: &[&[f32]], dim: usize) -> Vec<f64> {
    let mut mean = vec![0.0; dim];
    for row in rows {
        for (mean, &value) in mean.iter_mut().zip(*row) {
            *mean += f64::from(value);
        }
    }
    mean.iter_mut().for_each(|mean| *mean /= rows.len().max(1) as f64);
    mean
}

/// The covariance, each row of it summed over the rows in their order.
fn covariance(rows: &[&[f32]], mean: &[f64]) -> DMatrix<f64> {
    let dim = mean.len();
    let lines: Vec<Vec<f64>> = (0..dim)
        .into_par_iter()
        .map(|i| {
            let mut line = vec![0.0; i + 1];
            for row in rows {
                let centred = f64::from(row[i]) - mean[i];
                for ((sum, &value), mean) in line.iter_mut().zip(*row).zip(mean) {
                    *sum += centred * (f64::from(value) - mean);
                }
            }
            line
        })
        .collect();
    DMatrix::from_fn(dim, dim, |i, j| lines[i.max(j)][i.min(j)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixed_axes_keep_distances_and_vary_alike() {
        const DIM: usize = 64;
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let values: Vec<f32> = (0..2_000 * DIM)
            .map(|at| 0.95f32.powi((at % DIM) as i32) * rng.random_range(-1.0..1.0f32))
            .collect();
        let rows = Rows { values: &values, dim: DIM };
        let coordinates = |axes: &FittedAxes| -> Vec<f32> {
            let each = values.chunks_exact(DIM).flat_map(|row| {
                let mut coordinates = vec![0.0; axes.count];
                axes.as_axes().project(Simd::best(), row, &mut coordinates);
                coordinates
            });
            each.collect()
        };
        let fitted = fit(rows, true);
        let count = fitted.count;
        let (plain, mixed) = (coordinates(&fitted), coordinates(&fitted.mix()));
        let squares = |coordinates: &[f32]| coordinates.iter().map(|value| value * value).sum::<f32>();
        for (plain, mixed) in plain.chunks_exact(count).zip(mixed.chunks_exact(count)) {
            assert!((squares(plain) / squares(mixed) - 1.0).abs() < 1e-4);
        }
        // The largest variance of an axis by the least.
        let spread = |coordinates: &[f32]| {
            let of_axis =
                |axis: usize| coordinates.iter().skip(axis).step_by(count).map(|value| value * value).sum();
            let variances: Vec<f32> = (0..count).map(of_axis).collect();
            let largest = variances.iter().copied().fold(0.0, f32::max);
            largest / variances.iter().copied().fold(f32::INFINITY, f32::min)
        };
        assert!(spread(&plain) > 20.0 && spread(&mixed) < 8.0, "{} {}", spread(&plain), spread(&mixed));
    }

    #[test]
    fn axes_hold_what_is_not_measured_again_and_no_more_than_up_to_a_block() {
        const DIM: usize = 160;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        // Of value `at`, the spread is 0.98 to the power of its number, the variance its square.
        let spread = |at: usize| 0.98f32.powi(at as i32);
        let values: Vec<f32> =
            (0..4_000 * DIM).map(|at| spread(at % DIM) * rng.random_range(-1.0..1.0f32)).collect();
        let rows = Rows { values: &values, dim: DIM };
        let variance = |count: usize| (0..count).map(|at| f64::from(spread(at)).powi(2)).sum::<f64>();
        for (keeps_descriptors, wanted) in [(true, VARIANCE), (false, VARIANCE_OF_ALL)] {
            let count = fit(rows, keeps_descriptors).count;
            assert!(count.is_multiple_of(16), "{count}");
            let held = |count: usize| variance(count) / variance(DIM);
            assert!(
                held(count) > wanted - 0.005 && held(count - 16) < wanted + 0.005,
                "{count} for {wanted}"
            );
        }
    }

    #[test]
    fn there_are_some_axes_even_where_few_hold_it_all() {
        let axes = |dim: usize| {
            // All vary along the first three.
            let row = |at: usize| (0..dim).map(move |d| if d < 3 { (at * (d + 7) % 11) as f32 } else { 0.0 });
            let values: Vec<f32> = (0..500).flat_map(row).collect();
            fit(Rows { values: &values, dim }, true).count
        };
        assert_eq!([axes(84), axes(50), axes(30)], [FEWEST_AXES, 52, 32]);
    }
}
