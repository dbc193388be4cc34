//! Rotations as a network is asked for them, and as it answers.

use grasp_index::from_columns;
use grasp_train::ROTATION;
use nalgebra::UnitQuaternion;

/// The rows of the matrix that a network shall answer.
pub(super) fn rows(rotation: &UnitQuaternion<f64>) -> [[f32; 3]; 3] {
    let matrix = rotation.to_rotation_matrix();
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)] as f32))
}

/// The rotation that the last of a network's heads answer with.
pub(super) fn of_heads(heads: &[f32]) -> UnitQuaternion<f64> {
    let last = heads.last_chunk::<ROTATION>();
    last.and_then(|columns| from_columns(*columns)).unwrap_or_default()
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
