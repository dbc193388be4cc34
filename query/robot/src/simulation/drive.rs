//! One finger's motor: a worm gear, and a clutch that shares it between both joints.
//!
//! Inner and distal joint turn together, the distal by a third, until the inner link meets
//! something: where the torque there holds above the clutch's limit, the clutch lets go
//! ("breakaway"), the inner link is locked by its worm, and the motor turns the distal joint alone,
//! four thirds as fast. A worm gear does not turn back: a target only advances.

use super::barrett::LIMITS;

/// The motor's speed at the inner joint, in rad/s.
pub(super) const SPEED: f32 = 2.0;
/// Torque at the inner joint above which the clutch lets go, in N m.
const BREAKAWAY: f32 = 1.2;
/// For how long it must hold, in seconds: a knock is no grasp.
const BREAKAWAY_TIME: f32 = 0.008;
/// Torque at the inner joint at which the motor stalls where its clutch may not let go, in N m:
/// some 7 N at a finger's tip. The hand could press three times as hard, but then what two fingers
/// meet first is jammed between them before the third arrives.
const STALL: f32 = 0.8;
/// Torque at the distal joint at which the motor stalls, in N m.
const DISTAL_STALL: f32 = 0.8;

/// A finger's motor. Angles in radians, torques in N m.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    /// What the motor has turned, as the inner joint's angle.
    motor: f32,
    /// Where closing ends.
    end: f32,
    /// Whether the clutch may let go.
    clutch: bool,
    /// The inner joint's angle and the motor's when the clutch let go.
    broken: Option<f32>,
    /// For how long the inner torque has been above the clutch's limit.
    above: f32,
}

impl Drive {
    /// A finger whose inner joint stands at `open`; it closes to `end` at most.
    pub(super) fn new(open: f32, end: f32, clutch: bool) -> Self {
        Self { motor: open, end: end.min(LIMITS[0]), clutch, broken: None, above: 0.0 }
    }

    /// Where both joints are held: inner, distal.
    pub(super) fn targets(&self) -> [f32; 2] {
        match self.broken {
            None => [self.motor, (self.motor / 3.0).min(LIMITS[1])],
            // The motor turns on alone: from a third of the locked angle, four thirds as fast.
            Some(locked) => [locked, (4.0 / 3.0 * self.motor - locked).min(LIMITS[1])],
        }
    }

    /// Whether the clutch has let go.
    #[cfg(test)]
    fn has_broken_away(&self) -> bool {
        self.broken.is_some()
    }

    /// Closes for `dt` seconds against these torques at both joints.
    pub(super) fn close(&mut self, torques: [f32; 2], dt: f32) {
        let [inner, distal] = torques;
        if self.broken.is_some() {
            if distal < DISTAL_STALL && self.targets()[1] < LIMITS[1] {
                self.motor += SPEED * dt;
            }
            return;
        }
        self.above = if inner > BREAKAWAY { self.above + dt } else { 0.0 };
        if self.clutch && self.above > BREAKAWAY_TIME {
            self.broken = Some(self.motor);
        } else if inner < STALL && self.motor < self.end {
            self.motor = (self.motor + SPEED * dt).min(self.end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DT: f32 = 0.002;

    fn closed(drive: &mut Drive, torques: [f32; 2], steps: usize) -> [f32; 2] {
        (0..steps).for_each(|_| drive.close(torques, DT));
        drive.targets()
    }

    #[test]
    fn a_free_finger_bends_its_distal_joint_by_a_third() {
        let mut drive = Drive::new(0.3, 2.0, true);
        let [inner, distal] = closed(&mut drive, [0.0; 2], 250);
        assert!((inner - 1.3).abs() < 1e-3, "2 rad/s for half a second: {inner}");
        assert!((distal - inner / 3.0).abs() < 1e-6);
    }

    #[test]
    fn after_breakaway_the_inner_link_is_locked_and_the_distal_turns_four_thirds_as_fast() {
        let mut drive = Drive::new(0.6, 2.4, true);
        let [_, before] = closed(&mut drive, [0.0; 2], 50);
        let [locked, start] = closed(&mut drive, [1.5, 0.2], 6);
        assert!(drive.has_broken_away());
        assert!((start - before).abs() < 0.02, "the distal joint does not jump: {before} {start}");
        let [inner, distal] = closed(&mut drive, [1.5, 0.2], 50);
        assert_eq!(inner, locked);
        assert!((distal - start - 4.0 / 3.0 * SPEED * 50.0 * DT).abs() < 1e-4, "{start} {distal}");
    }

    #[test]
    fn a_knock_does_not_free_the_clutch() {
        let mut drive = Drive::new(0.6, 2.4, true);
        for _ in 0..20 {
            drive.close([1.5, 0.0], DT);
            drive.close([1.5, 0.0], DT);
            drive.close([0.1, 0.0], DT);
        }
        assert!(!drive.has_broken_away());
    }

    #[test]
    fn without_the_clutch_both_joints_stall_together() {
        let mut drive = Drive::new(0.6, 2.4, false);
        let before = closed(&mut drive, [0.7, 0.3], 10);
        assert!(!drive.has_broken_away() && before[0] > 0.6);
        assert_eq!(closed(&mut drive, [1.3, 0.3], 100), before, "stalled");
    }

    proptest! {
        /// A worm gear is not driven back, and no joint passes its limit, whatever pushes.
        #[test]
        fn targets_only_advance_within_the_limits(
            open in 0.0f32..2.4,
            clutch: bool,
            torques in prop::collection::vec(prop::array::uniform2(-5.0f32..5.0), 1..1500),
        ) {
            let mut drive = Drive::new(open, 9.0, clutch);
            let mut before = drive.targets();
            for torque in torques {
                drive.close(torque, DT);
                let now = drive.targets();
                for joint in 0..2 {
                    prop_assert!(now[joint] >= before[joint] - 1e-6 && now[joint] <= LIMITS[joint] + 1e-6);
                }
                before = now;
            }
        }
    }
}
