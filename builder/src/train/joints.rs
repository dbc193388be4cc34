//! What a network is taught of a hand's joints besides what it shall answer.

use grasp_renders::JointPlaces;
use nalgebra::{UnitQuaternion, Vector3};

/// How many places are taught.
pub(super) const COUNT: usize = 40;

/// Where a hand's joints are, in hand lengths from the wrist, in its own frame.
#[derive(Clone, Debug)]
pub struct Joints([Vector3<f32>; COUNT / 2]);

impl Joints {
    /// Of a hand that is `hand_length` metres long.
    pub(super) fn new(places: &JointPlaces, hand_length: f64) -> Self {
        let places = places.as_flattened();
        Self(std::array::from_fn(|joint| places[joint] / hand_length as f32))
    }

    /// The places in the frame of a picture that shows the hand in an orientation, then those in
    /// the hand's own: what is seen, and how it is bent.
    pub(super) fn values(&self, orientation: &UnitQuaternion<f64>) -> Vec<f32> {
        let turn = orientation.to_rotation_matrix().matrix().cast::<f32>();
        let seen = self.0.iter().map(|place| turn * place);
        seen.chain(self.0).flat_map(|place| [place.x, place.y, place.z]).collect()
    }
}

/// The values of a picture without joints.
pub(super) fn unknown() -> Vec<f32> {
    vec![0.0; 3 * COUNT]
}
