//! Rotations as a network is asked for them, and as it answers.

use grasp_train::{ROTATION, rotation_of};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

/// The rows of the matrix that a network shall answer.
pub(super) fn rows(rotation: &UnitQuaternion<f64>) -> [[f32; 3]; 3] {
    let matrix = rotation.to_rotation_matrix();
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)] as f32))
}

/// The rotation that the last of a network's heads answer with.
pub(super) fn of_heads(heads: &[f32]) -> UnitQuaternion<f64> {
    let last = heads.last_chunk::<ROTATION>().copied().unwrap_or_default();
    let rows = rotation_of(last);
    let matrix = Matrix3::from_fn(|row, column| f64::from(rows[row][column]));
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotations_columns_come_back_as_it() {
        let rotation = UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0);
        let rows = rows(&rotation);
        let mut heads = vec![7.0];
        heads.extend((0..2).flat_map(|column| rows.map(|row| row[column])));
        assert!(of_heads(&heads).angle_to(&rotation) < 1e-3);
    }
}
