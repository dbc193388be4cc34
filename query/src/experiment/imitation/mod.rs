//! The paper's Figure 1 end to end: from a picture of a hand, through its recognised grasp and
//! orientation with their real errors, to a robot hand that lifts the object, or does not.
//!
//! Each picture's hand is put where a person's would be on an object that the labelled grasp is
//! for, and turned by the error that the recognition made: `world_from_hand * labelled^-1 *
//! recognised`. The robot then imitates what was recognised, class and orientation, on that object.
//! The object's position is exact, as in the paper.

use grasp_terminal::text::counted;
use nalgebra::UnitQuaternion;
use rayon::prelude::*;
use serde::Serialize;

use crate::evaluate::Outcome;
use crate::evaluate::confusion::Share;
use crate::evaluate::errors::median;
use crate::evaluate::labels::RowError;
use crate::evaluate::report::{Report, RowReport, errors_text};
use grasp_recognise::Side;
use grasp_robot::simulation::{Offset, Plan, Scene};
use grasp_robot::{RobotError, RobotHand, hand_from_palm};

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Imitation {
    /// The robot hand.
    pub robot: String,
    /// What simulated it.
    pub engine: &'static str,
    /// Each labelled class, and all of them.
    pub classes: Vec<ClassResult>,
    /// Pictures that no trial was made of: they are labelled with no orientation, or with none of
    /// the six grasps.
    pub left_out: usize,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
}

/// The pictures of one class.
#[derive(Clone, Debug, Serialize)]
pub struct ClassResult {
    /// The labelled grasp, or `all`.
    pub grasp: String,
    /// The object that it is tried on.
    pub object: String,
    /// Pictures.
    pub n: usize,
    /// In which the grasp was recognised.
    pub recognised: usize,
    /// In which the robot grasp was the right one: several human grasps share one.
    pub robot_grasp_right: usize,
    /// In which the object was lifted and held; what was not recognised, or is unknown, was not.
    pub success: usize,
    /// The share of these, 0..=1.
    pub share: f64,
    /// Where the true share lies, with 95 % confidence.
    pub interval: [f64; 2],
    /// In which it would have been with the recognised class and the labelled orientation.
    pub success_with_true_orientation: usize,
    /// The median angle between labelled and recognised orientation, in degrees.
    pub orientation_error_deg: Option<f64>,
}

/// What became of one picture.
#[derive(Clone, Debug)]
struct Case {
    grasp: String,
    recognised: bool,
    robot_grasp_right: bool,
    success: bool,
    true_orientation: bool,
    error_deg: Option<f64>,
}

impl Imitation {
    /// Tries what was recognised in each picture that could be read; `broken` are rows that could
    /// not. `tick` is called after each.
    ///
    /// # Errors
    /// [`RobotError`]: the hand cannot be simulated.
    pub fn new(
        hand: &RobotHand,
        outcomes: &[Outcome],
        broken: &[RowError],
        tick: impl Fn() + Sync,
    ) -> Result<Self, RobotError> {
        let cases: Vec<Option<Case>> = outcomes
            .par_iter()
            .filter(|outcome| outcome.was_read())
            .map(|outcome| {
                let case = Case::new(hand, outcome);
                tick();
                case
            })
            .collect::<Result<_, _>>()?;
        let left_out = cases.iter().filter(|case| case.is_none()).count();
        let cases: Vec<Case> = cases.into_iter().flatten().collect();
        let mut names: Vec<&str> = cases.iter().map(|case| case.grasp.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let mut classes: Vec<ClassResult> =
            names.into_iter().map(|name| ClassResult::new(name, &cases, |case| case.grasp == name)).collect();
        classes.push(ClassResult::new("all", &cases, |_| true));
        let errors = Report::new(Vec::new(), outcomes, broken, false).errors;
        Ok(Self { robot: hand.name.clone(), engine: super::robustness::ENGINE, classes, left_out, errors })
    }

    /// The table for a person.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{:17}{:18}{:>5}{:>12}{:>13}{:>9}{:>16}{:>18}{:>14}\n",
            "grasp",
            "object",
            "n",
            "recognised",
            "robot right",
            "success",
            "(95 %)",
            "true orientation",
            "median error"
        );
        for row in &self.classes {
            let percent = |count: usize| format!("{:.0} %", 100.0 * count as f64 / row.n.max(1) as f64);
            let interval = format!("({:.0}-{:.0} %)", 100.0 * row.interval[0], 100.0 * row.interval[1]);
            let error = row.orientation_error_deg.map_or("-".into(), |error| format!("{error:.0}°"));
            text += &format!(
                "{:17}{:18}{:>5}{:>12}{:>13}{:>9}{interval:>16}{:>18}{error:>14}\n",
                row.grasp,
                row.object,
                row.n,
                percent(row.recognised),
                percent(row.robot_grasp_right),
                percent(row.success),
                percent(row.success_with_true_orientation),
            );
        }
        let left_out = counted(self.left_out, ["picture", "pictures"]);
        text += &format!("{left_out} left out; {} by {}\n", self.robot, self.engine);
        text + &errors_text(&self.errors)
    }
}

impl Case {
    fn new(hand: &RobotHand, outcome: &Outcome) -> Result<Option<Self>, RobotError> {
        let label = &outcome.label;
        let (Some(labelled), Some(scene)) = (label.orientation, Scene::for_human(&label.grasp)) else {
            return Ok(None);
        };
        let (robot_grasp, _) = hand.for_human(&label.grasp)?;
        let mut case = Self {
            grasp: label.grasp.clone(),
            recognised: false,
            robot_grasp_right: false,
            success: false,
            true_orientation: false,
            error_deg: None,
        };
        let Ok(guess) = &outcome.result else { return Ok(Some(case)) };
        let side = label.hand.unwrap_or(guess.hand);
        let error = labelled.inverse() * guess.orientation;
        case.error_deg = Some(error.angle().to_degrees());
        // What is unknown, or has no counterpart, is not imitated.
        let Ok((guessed, _)) = hand.for_human(&guess.grasp) else { return Ok(Some(case)) };
        case.recognised = guess.grasp == label.grasp;
        case.robot_grasp_right = guessed == robot_grasp;
        let attempt = |error: UnitQuaternion<f64>| -> Result<bool, RobotError> {
            let turned = turned(scene, &label.grasp, &guess.grasp, side, guess.hand, error)?;
            match Plan::new(hand, guessed, &scene.object()?, turned) {
                Ok(plan) => Ok(plan.run(Offset::default()).success),
                // A failure of this hand on this object, as it would be with a real one.
                Err(RobotError::TooWide { .. }) => Ok(false),
                Err(error) => Err(error),
            }
        };
        case.success = attempt(error)?;
        case.true_orientation = attempt(UnitQuaternion::identity())?;
        Ok(Some(case))
    }
}

/// How the palm is turned in the world: a person's hand round the scene's object, off by `error`,
/// imitated as `guessed`.
fn turned(
    scene: &Scene,
    labelled: &str,
    guessed: &str,
    side: Side,
    guessed_side: Side,
    error: UnitQuaternion<f64>,
) -> Result<UnitQuaternion<f64>, RobotError> {
    let world_from_hand = scene.from.turned() * hand_from_palm(labelled, side)?.inverse();
    Ok(world_from_hand * error * hand_from_palm(guessed, guessed_side)?)
}

impl ClassResult {
    fn new(grasp: &str, cases: &[Case], holds: impl Fn(&Case) -> bool) -> Self {
        let own: Vec<&Case> = cases.iter().filter(|case| holds(case)).collect();
        let count = |what: fn(&Case) -> bool| own.iter().filter(|case| what(case)).count();
        let errors = own.iter().filter_map(|case| case.error_deg).collect();
        let success = count(|case| case.success);
        let share = Share { n: own.len(), right: success };
        Self {
            grasp: grasp.to_owned(),
            object: Scene::for_human(grasp).map_or("", |scene| scene.name).to_owned(),
            n: own.len(),
            recognised: count(|case| case.recognised),
            robot_grasp_right: count(|case| case.robot_grasp_right),
            success,
            share: share.top1(),
            interval: share.interval(),
            success_with_true_orientation: count(|case| case.true_orientation),
            orientation_error_deg: median(errors),
        }
    }
}
