//! Muon: a matrix goes along its momentum, made orthogonal.
//!
//! A gradient of a matrix has a few large singular values, and what the many small ones say would
//! be learned late. Here each step has about the same length along all of them. The matrix of the
//! momentum is brought to its nearest orthogonal one by a polynomial that takes its singular values
//! to about 1 (K. Jordan, "Muon: An optimizer for hidden layers in neural networks", 2024). Steps
//! are scaled so that they change a weight as much as Adam's do (J. Liu et al., "Muon is scalable
//! for LLM training", 2025), and learning rates are the same for both.

use crate::matrix::{Before, Matrix, multiply};

/// The share of the momentum that stays at each step.
const MOMENTUM: f32 = 0.95;
/// Applications of the polynomial, and its factors of a singular value, its cube and its fifth
/// power.
const TIMES: usize = 5;
const POLYNOMIAL: [f32; 3] = [3.4445, -4.7750, 2.0315];
/// How far a weight is moved at a learning rate of 1 (root of the mean square).
const STEP: f32 = 0.2;

/// What is done in a step.
pub(super) struct Muon {
    learning_rate: f32,
    weight_decay: f32,
}

impl Muon {
    pub(super) fn new(learning_rate: f32, weight_decay: f32) -> Self {
        Self { learning_rate, weight_decay }
    }

    /// Moves a matrix, row by row, against its gradients.
    pub(super) fn step(&self, weights: &mut [f32], momentum: &mut [f32], gradients: &[f32], columns: usize) {
        let rows = weights.len() / columns;
        let ahead = momentum.iter_mut().zip(gradients).map(|(momentum, gradient)| {
            *momentum = MOMENTUM * *momentum + (1.0 - MOMENTUM) * gradient;
            MOMENTUM * *momentum + (1.0 - MOMENTUM) * gradient
        });
        let update = orthogonal(ahead.collect(), columns);
        let times = STEP * (rows.max(columns) as f32).sqrt();
        for (weight, update) in weights.iter_mut().zip(update) {
            *weight -= self.learning_rate * (times * update + self.weight_decay * *weight);
        }
    }
}

/// About the orthogonal matrix nearest to one whose rows have `columns` values: its singular values
/// are mostly between 0.6 and 1.3, and those of a matrix of zeros 0.
fn orthogonal(mut matrix: Vec<f32>, columns: usize) -> Vec<f32> {
    let norm = matrix.iter().map(|v| f64::from(*v) * f64::from(*v)).sum::<f64>().sqrt();
    let scale = (1.0 / norm.max(1e-20)) as f32;
    matrix.iter_mut().for_each(|value| *value *= scale);
    let rows = matrix.len() / columns;
    let side = rows.min(columns);
    let [mut gram, mut factor] = [(); 2].map(|()| vec![0.0; side * side]);
    let mut added = vec![0.0; matrix.len()];
    let [first, third, fifth] = POLYNOMIAL;
    for _ in 0..TIMES {
        let view = Matrix::new(&matrix, rows, columns);
        // The smaller of both products with the transpose.
        let [left, right] =
            if rows < columns { [view, view.transposed()] } else { [view.transposed(), view] };
        multiply(left, right, Before::Replace, &mut gram);
        let square = Matrix::new(&gram, side, side);
        multiply(square, square, Before::Replace, &mut factor);
        factor.iter_mut().zip(&gram).for_each(|(of_fifth, of_third)| {
            *of_fifth = fifth * *of_fifth + third * of_third;
        });
        let factor = Matrix::new(&factor, side, side);
        let [left, right] = if rows < columns { [factor, view] } else { [view, factor] };
        multiply(left, right, Before::Replace, &mut added);
        matrix.iter_mut().zip(&added).for_each(|(value, added)| *value = first * *value + added);
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `rows * columns` values that no direction is missing in.
    fn values(rows: usize, columns: usize) -> Vec<f32> {
        (0..rows * columns).map(|at| (at * at * 31 % 101) as f32 / 50.0 - 1.0).collect()
    }

    fn transposed(values: &[f32], columns: usize) -> Vec<f32> {
        let rows = values.len() / columns;
        (0..values.len()).map(|at| values[at % rows * columns + at / rows]).collect()
    }

    #[test]
    fn singular_values_come_to_about_1() {
        for (rows, columns) in [(40, 7), (7, 40), (9, 9), (5, 1)] {
            let found = orthogonal(values(rows, columns), columns);
            let matrix = nalgebra::DMatrix::from_row_slice(rows, columns, &found);
            let singular = matrix.singular_values();
            assert!(
                singular.iter().all(|value| (0.3..1.4).contains(value)),
                "{rows} x {columns}: {singular}"
            );
        }
        assert_eq!(orthogonal(vec![0.0; 12], 3), [0.0; 12]);
    }

    #[test]
    fn a_transpose_is_made_orthogonal_as_the_matrix_is() {
        let (tall, wide) = (values(30, 8), transposed(&values(30, 8), 8));
        let (tall, wide) = (transposed(&orthogonal(tall, 8), 8), orthogonal(wide, 30));
        assert!(tall.iter().zip(wide).all(|(a, b)| (a - b).abs() < 1e-3));
    }

    #[test]
    fn a_matrix_comes_to_where_its_gradient_is_0() {
        let wanted = values(20, 6);
        let (mut weights, mut momentum) = (vec![0.0; 120], vec![0.0; 120]);
        for step in 0..400 {
            let gradients: Vec<f32> = weights.iter().zip(&wanted).map(|(w, to)| w - to).collect();
            let muon = Muon::new(0.1 * (1.0 - step as f32 / 400.0), 0.0);
            muon.step(&mut weights, &mut momentum, &gradients, 6);
        }
        assert!(weights.iter().zip(wanted).all(|(weight, to)| (weight - to).abs() < 0.05));
    }
}
