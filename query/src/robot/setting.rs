//! The robot and all that is given to it, read once for many pictures.

use super::{Arm, Camera, Object, RobotError, RobotHand, Seen, Strategy};
use crate::output::record::{Answer, ErrorRecord};
use grasp_recognise::Recognition;

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
    /// Where the object lies in its table, which nothing that a picture shows could mend.
    pub fn new(hand: RobotHand, object: Object, camera: Camera) -> Result<Self, RobotError> {
        object.in_world(&camera)?;
        Ok(Self { hand, object, camera, arm: None })
    }

    /// With an arm that carries the hand.
    pub fn with_arm(self, arm: Option<Arm>) -> Self {
        Self { arm, ..self }
    }

    /// Puts the strategy into an answer, or why there is none. What is unknown is not imitated.
    pub fn complete(&self, answer: &mut Answer, found: &Recognition) {
        if answer.reason.is_some() {
            return;
        }
        let seen = Seen {
            grasp: answer.grasp.clone(),
            side: found.best.side,
            camera_from_hand: found.best.vote.orientation.rotation,
            spread_deg: found.best.vote.orientation.spread_deg,
        };
        match Strategy::new(&self.hand, &seen, &self.object, &self.camera) {
            Ok(strategy) => {
                answer.strategy = Some(match &self.arm {
                    Some(arm) => strategy.carried_by(arm),
                    None => strategy,
                });
            }
            Err(error) => {
                let message = error.to_string();
                answer.error = Some(ErrorRecord { kind: error.kind(), message, is_rejection: false });
            }
        }
    }
}
