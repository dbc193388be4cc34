//! The robot and all that is given to it, read once for many pictures.

use nalgebra::Vector3;

use super::{Arm, Camera, Object, ObservedHand, RobotError, RobotHand, Strategy};

/// A robot hand, what it is to grasp, and from where that was seen.
#[derive(Debug)]
pub struct Setting {
    hand: RobotHand,
    object: Object,
    camera: Camera,
    arm: Option<Arm>,
}

impl Setting {
    /// A setting.
    ///
    /// # Errors
    /// Where the object lies in its table or behind the camera, which nothing that a picture shows
    /// could mend.
    pub fn new(hand: RobotHand, object: Object, camera: Camera) -> Result<Self, RobotError> {
        object.seen_by(&camera)?;
        Ok(Self { hand, object, camera, arm: None })
    }

    /// With an arm that carries the hand.
    pub fn with_arm(self, arm: Option<Arm>) -> Self {
        Self { arm, ..self }
    }

    /// The strategy that imitates `seen`.
    ///
    /// # Errors
    /// As [`Strategy::new`].
    pub fn strategy(&self, seen: &ObservedHand) -> Result<Strategy, RobotError> {
        let strategy = Strategy::new(&self.hand, seen, &self.object, &self.camera)?;
        Ok(match &self.arm {
            Some(arm) => strategy.carried_by(arm),
            None => strategy,
        })
    }

    /// The direction in which the palm of a strategy of this setting comes to the object, of length
    /// 1 in the camera's optical frame (x right, y down, z forward).
    pub fn approach_in_camera(&self, strategy: &Strategy) -> Vector3<f64> {
        let approach = strategy.palm_in_world.isometry().rotation * Vector3::z();
        self.camera.world_from_camera.rotation.inverse_transform_vector(&approach)
    }
}
