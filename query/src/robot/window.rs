//! What error a grasp tolerates: the windows that were simulated, and which of them counts for an object.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::strategy::Estimate;
use super::{From, RobotGrasp};

/// Beyond the thinnest and the widest object that were simulated a window is taken over as far as this: to a hand that is turned
/// 30 degrees too far a round thing looks 15 % wider than it is.
const BEYOND: f64 = 1.2;
/// Widths that differ by less are the same, in metres.
const SAME: f64 = 1e-3;

/// An error that is tolerated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// The object's place on the table may be wrong by as much as this in either direction, in metres.
    pub position_m: f64,
    /// The hand's turn about the vertical may be wrong by as much as this in either direction, in radians; none where any will do.
    pub yaw_rad: Option<f64>,
    /// The approach may be tilted by as much as this in any direction, in radians; none where that was not simulated.
    pub tilt_rad: Option<f64>,
    /// What one link pressed with, at most, where object and hand were where they should be, in newtons; none where that was
    /// not measured.
    pub force_n: Option<f64>,
    /// The object that this was simulated with.
    pub object: String,
    /// That object's extent across the closing fingers, in metres.
    pub width_m: f64,
    /// From where the hand came to it.
    pub from: From,
    /// What simulated it.
    pub engine: String,
}

impl Window {
    /// The one of `windows` that counts for an object as wide as `width`, in metres, to which the hand comes `from`: between two
    /// objects that were simulated, the narrower of theirs, and the greater force. `None` where none so thin or so wide was.
    pub(super) fn of(windows: &[Self], width: f64, from: From) -> Option<Self> {
        let comparable = || windows.iter().filter(|window| window.from == from);
        let widths = || comparable().map(|window| window.width_m);
        let thinner = widths().filter(|other| *other <= width + SAME).reduce(f64::max);
        let wider = widths().filter(|other| *other >= width - SAME).reduce(f64::min);
        let is_beyond = match (thinner, wider) {
            (None, Some(wider)) => wider > BEYOND * width,
            (Some(thinner), None) => width > BEYOND * thinner,
            _ => false,
        };
        if is_beyond {
            return None;
        }
        let near = || comparable().filter(|window| [thinner, wider].contains(&Some(window.width_m)));
        let narrowest = near().min_by(|a, b| a.position_m.total_cmp(&b.position_m))?;
        let yaw_rad = near().filter_map(|window| window.yaw_rad).reduce(f64::min);
        let tilt_rad = near().filter_map(|window| window.tilt_rad).reduce(f64::min);
        let force_n = near().filter_map(|window| window.force_n).reduce(f64::max);
        Some(Self { yaw_rad, tilt_rad, force_n, ..narrowest.clone() })
    }
}

/// What error the grasp tolerates on something as wide, in metres, to which the hand moves along `approach`, of unit length in the world.
pub(super) fn tolerated(grasp: &RobotGrasp, width: f64, approach: &Vector3<f64>) -> Option<Window> {
    Window::of(&grasp.window, width, From::of(approach)?)
}

/// The probability that an error of the estimate's spread stays within `window`, were it normal and the same in each direction:
/// in both directions along the table, and of the turn that is tolerated least. `None` where a spread or the tolerated turn is
/// unknown. The estimate's whole angle is taken for the error of that one turn, which is at most as much.
pub(super) fn confidence(estimate: &Estimate, window: &Window) -> Option<f64> {
    let turn = window.tilt_rad.into_iter().chain(window.yaw_rad).reduce(f64::min)?;
    let position = within(window.position_m, estimate.position_m?);
    Some(position * position * within(turn, estimate.orientation_rad))
}

/// The probability that a normal error of this standard deviation is at most `most` in either direction.
fn within(most: f64, deviation: f64) -> f64 {
    // Of the error function, Abramowitz and Stegun 7.1.26: to 1.5e-7.
    let x = most / deviation.max(f64::MIN_POSITIVE) * std::f64::consts::FRAC_1_SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let polynomial = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let sum = polynomial.into_iter().fold(0.0, |sum, coefficient| sum * t + coefficient) * t;
    (1.0 - sum * (-x * x).exp()).clamp(0.0, 1.0)
}

/// Where the estimate is worse than the grasp tolerates, or one of them is not known; see [`tolerated`].
pub(super) fn doubts(
    estimate: &Estimate,
    grasp: &RobotGrasp,
    width: f64,
    approach: &Vector3<f64>,
) -> Vec<String> {
    let Some(window) = tolerated(grasp, width, approach) else {
        return vec![unknown(grasp, width, approach)];
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
    let turns = [("tilt", window.tilt_rad), ("yaw", window.yaw_rad)];
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
fn unknown(grasp: &RobotGrasp, width: f64, approach: &Vector3<f64>) -> String {
    let from = From::of(approach);
    let tried = grasp.window.iter().filter(|window| Some(window.from) == from);
    let tried: Vec<String> =
        tried.map(|window| format!("{} ({:.0} mm)", window.object, 1e3 * window.width_m)).collect();
    let why = match (tried.as_slice(), grasp.window.is_empty()) {
        ([], true) => "it was never simulated".into(),
        ([], false) => format!("it was never simulated {}", from.map_or("from below", From::words)),
        (tried, _) => {
            let words = from.map_or("", From::words);
            format!("simulated {words} were {}, and this is {:.0} mm wide", tried.join(", "), 1e3 * width)
        }
    };
    format!("what error the grasp tolerates is not known: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(from: From, width_m: f64, position_m: f64, yaw_rad: Option<f64>) -> Window {
        let (object, engine) = (format!("{width_m}"), "none".into());
        let tilt_rad = yaw_rad.map(|yaw| 0.5 * yaw);
        Window {
            position_m,
            yaw_rad,
            tilt_rad,
            force_n: Some(100.0 * width_m),
            object,
            width_m,
            from,
            engine,
        }
    }

    #[test]
    fn an_error_as_large_as_its_window_is_within_it_in_two_of_three() {
        let erf = [(0.5, 0.382_925), (1.0, 0.682_689), (2.0, 0.954_500), (3.0, 0.997_300)];
        for (deviations, share) in erf {
            assert!((within(0.02 * deviations, 0.02) - share).abs() < 1e-6, "{deviations}");
        }
        assert_eq!((within(0.02, 0.0), within(0.0, 0.02).abs() < 1e-6), (1.0, true));
        let estimate = |position_m| Estimate { position_m, orientation_rad: 0.25, hand_position: "given" };
        // Tilt, 0.25 rad, is what is tolerated less than yaw.
        let window = window(From::Top, 0.06, 0.02, Some(0.5));
        let both = confidence(&estimate(Some(0.01)), &window).unwrap();
        assert!((both - 0.954_500_f64.powi(2) * 0.682_689).abs() < 1e-5, "{both}");
        assert_eq!(confidence(&estimate(None), &window), None);
        let untried = Window { yaw_rad: None, tilt_rad: None, ..window };
        assert_eq!(confidence(&estimate(Some(0.01)), &untried), None);
    }

    #[test]
    fn between_two_objects_the_narrower_window_counts() {
        let windows = [
            window(From::Side, 0.03, 0.01, None),
            window(From::Side, 0.07, 0.03, Some(0.5)),
            window(From::Top, 0.06, 0.04, Some(0.8)),
            window(From::Top, 0.07, 0.02, Some(0.9)),
            window(From::Top, 0.07, 0.03, Some(0.7)),
        ];
        let at =
            |width, from| Window::of(&windows, width, from).map(|found| (found.position_m, found.yaw_rad));
        assert_eq!(at(0.030, From::Side), Some((0.01, None)));
        assert_eq!(at(0.0304, From::Side), Some((0.01, None)), "the same width, but for rounding");
        assert_eq!(at(0.050, From::Side), Some((0.01, Some(0.5))));
        assert_eq!(at(0.070, From::Side), Some((0.03, Some(0.5))));
        assert_eq!(at(0.060, From::Top), Some((0.04, Some(0.8))));
        assert_eq!(at(0.065, From::Top), Some((0.02, Some(0.7))), "of two as wide the narrower");
        // A little beyond those that were simulated, and farther.
        assert_eq!(at(0.080, From::Top), Some((0.02, Some(0.7))));
        assert_eq!(at(0.026, From::Side), Some((0.01, None)));
        assert_eq!((at(0.090, From::Top), at(0.020, From::Side), at(0.045, From::Top)), (None, None, None));
        assert_eq!(Window::of(&[], 0.05, From::Top), None);
        let found = Window::of(&windows, 0.065, From::Top).unwrap();
        assert_eq!((found.tilt_rad, found.force_n), (Some(0.35), Some(100.0 * 0.07)));
    }
}
