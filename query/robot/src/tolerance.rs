//! Whether the estimate of a hand is good enough for what the grasp tolerates.

use serde::Serialize;

use super::applicable::{NoWindow, applicable};
use super::attitude::Attitude;
use super::window::Window;
use super::{ApproachSide, RobotGrasp};

/// How uncertain the estimate is, as standard deviations.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Estimate {
    /// Of the hand's position in each direction; null where it is unknown.
    pub position_m: Option<f64>,
    /// Of its orientation, the whole angle: of the yaw at most as much.
    pub orientation_rad: f64,
    /// `given`, or `assumed`: that the hand holds the object as people do.
    pub hand_position: &'static str,
}

/// What error the grasp tolerates on something as wide, in metres, that lies so to the hand;
/// `None` for the attitude where the hand comes from below.
pub(super) fn tolerated(
    grasp: &RobotGrasp,
    width: f64,
    attitude: Option<&Attitude>,
) -> Result<Window, NoWindow> {
    applicable(&grasp.window, width, attitude)
}

/// The probability that an error of the estimate's spread stays within `window`, were it normal and
/// the same in each direction: in both directions along the table, and of the turn that is
/// tolerated least. `None` where a spread or the tolerated turn is unknown. The estimate's whole
/// angle is taken for the error of that one turn, which is at most as much.
pub(super) fn confidence(estimate: &Estimate, window: &Window) -> Option<f64> {
    let turns = [window.tilt_rad, window.yaw_rad, window.roll_rad];
    let turn = turns.into_iter().flatten().reduce(f64::min)?;
    let position = within(window.position_m, estimate.position_m?);
    Some(position * position * within(turn, estimate.orientation_rad))
}

/// The probability that a normal error of this standard deviation is at most `most` in either
/// direction.
fn within(most: f64, deviation: f64) -> f64 {
    // Of the error function, Abramowitz and Stegun 7.1.26: to 1.5e-7.
    let x = most / deviation.max(f64::MIN_POSITIVE) * std::f64::consts::FRAC_1_SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let polynomial = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let sum = polynomial.into_iter().fold(0.0, |sum, coefficient| sum * t + coefficient) * t;
    (1.0 - sum * (-x * x).exp()).clamp(0.0, 1.0)
}

/// Where the estimate is worse than the grasp tolerates, or one of them is not known; see
/// [`tolerated`].
pub(super) fn doubts(
    estimate: &Estimate,
    grasp: &RobotGrasp,
    width: f64,
    attitude: Option<&Attitude>,
) -> Vec<String> {
    let window = match tolerated(grasp, width, attitude) {
        Ok(window) => window,
        Err(why) => return vec![unknown(&why, grasp, width, attitude.map(|attitude| attitude.from))],
    };
    let mut doubts = Vec::new();
    match estimate.position_m {
        None => doubts.push("the hand's position has no known spread: give `position_spread`".into()),
        Some(spread) if spread > window.position_m => doubts.push(format!(
            "the hand's position is known to +-{:.0} mm, the grasp tolerates +-{:.0} mm",
            1e3 * spread,
            1e3 * window.position_m
        )),
        Some(_) => {}
    }
    let turns = [("tilt", window.tilt_rad), ("yaw", window.yaw_rad), ("roll", window.roll_rad)];
    let turns = turns.into_iter().filter_map(|(what, turn)| Some((what, turn?)));
    let narrowest = turns.min_by(|(_, a), (_, b)| a.total_cmp(b));
    if let Some((what, turn)) = narrowest.filter(|(_, turn)| estimate.orientation_rad > *turn) {
        doubts.push(format!(
            "the hand's orientation is known to +-{:.0} degrees, the grasp tolerates a {what} of +-{:.0}: take it as a first guess and correct it by touch",
            estimate.orientation_rad.to_degrees(),
            turn.to_degrees()
        ));
    }
    doubts
}

/// That, and why, no window is known.
fn unknown(why: &NoWindow, grasp: &RobotGrasp, width: f64, from: Option<ApproachSide>) -> String {
    let words = from.map_or("from below", ApproachSide::words);
    let tried = || {
        let tried = grasp.window.iter().filter(|window| Some(window.from) == from);
        let tried = tried.map(|window| format!("{} ({:.0} mm)", window.object, 1e3 * window.width_m));
        tried.collect::<Vec<_>>().join(", ")
    };
    let why = match why {
        NoWindow::Never => "it was never simulated".into(),
        NoWindow::Side => format!("it was never simulated {words}"),
        NoWindow::Attitude => {
            format!("simulated {words} were {}, and none lay to the palm as this does", tried())
        }
        NoWindow::Width => {
            format!("simulated {words} were {}, and this is {:.0} mm wide", tried(), 1e3 * width)
        }
        NoWindow::Off { how, by, most } => format!(
            "the hand is {how} by {:.0} degrees from how it came {words} in simulation, where up to {:.0} were held",
            by.to_degrees(),
            most.to_degrees()
        ),
    };
    format!("what error the grasp tolerates is not known: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_as_large_as_its_window_is_within_it_in_two_of_three() {
        let erf = [(0.5, 0.382_925), (1.0, 0.682_689), (2.0, 0.954_500), (3.0, 0.997_300)];
        for (deviations, share) in erf {
            assert!((within(0.02 * deviations, 0.02) - share).abs() < 1e-6, "{deviations}");
        }
        assert_eq!((within(0.02, 0.0), within(0.0, 0.02).abs() < 1e-6), (1.0, true));
        let estimate = |position_m| Estimate { position_m, orientation_rad: 0.25, hand_position: "given" };
        // Tilt, 0.25 rad, is what is tolerated less than yaw.
        let window = Window {
            position_m: 0.02,
            yaw_rad: Some(0.5),
            tilt_rad: Some(0.25),
            roll_rad: None,
            force_n: None,
            object: "any".into(),
            width_m: 0.06,
            from: ApproachSide::Top,
            axis: None,
            engine: "none".into(),
        };
        let both = confidence(&estimate(Some(0.01)), &window).unwrap();
        assert!((both - 0.954_500_f64.powi(2) * 0.682_689).abs() < 1e-5, "{both}");
        assert_eq!(confidence(&estimate(None), &window), None);
        let untried = Window { yaw_rad: None, tilt_rad: None, ..window };
        assert_eq!(confidence(&estimate(Some(0.01)), &untried), None);
    }
}
