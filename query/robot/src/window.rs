//! What error a grasp tolerated in simulation, and which of the simulated windows counts for an
//! object.

use serde::{Deserialize, Serialize};

use super::ApproachSide;

/// Beyond the thinnest and the widest object that were simulated a window is taken over as far as
/// this: to a hand that is turned 30 degrees too far a round thing looks 15 % wider than it is.
const BEYOND: f64 = 1.2;
/// Widths that differ by less are the same, in metres.
const SAME: f64 = 1e-3;

/// An error that is tolerated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// The object's place on the table may be wrong by as much as this in either direction, in
    /// metres.
    pub position_m: f64,
    /// The hand's turn about the vertical may be wrong by as much as this in either direction, in
    /// radians; none where any will do.
    pub yaw_rad: Option<f64>,
    /// The approach may be tilted by as much as this in any direction, in radians; none where that
    /// was not simulated.
    pub tilt_rad: Option<f64>,
    /// What one link pressed with, at most, where object and hand were where they should be, in
    /// newtons; none where that was not measured.
    pub force_n: Option<f64>,
    /// The object that this was simulated with.
    pub object: String,
    /// That object's extent across the closing fingers, in metres.
    pub width_m: f64,
    /// From where the hand came to it.
    pub from: ApproachSide,
    /// What simulated it.
    pub engine: String,
}

impl Window {
    /// The one of `windows` that counts for an object as wide as `width`, in metres, to which the
    /// hand comes `from`: between two objects that were simulated, the narrower of theirs, and the
    /// greater force. `None` where none so thin or so wide was.
    pub(super) fn for_width(windows: &[Self], width: f64, from: ApproachSide) -> Option<Self> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn window(from: ApproachSide, width_m: f64, position_m: f64, yaw_rad: Option<f64>) -> Window {
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
    fn between_two_objects_the_narrower_window_counts() {
        let windows = [
            window(ApproachSide::Side, 0.03, 0.01, None),
            window(ApproachSide::Side, 0.07, 0.03, Some(0.5)),
            window(ApproachSide::Top, 0.06, 0.04, Some(0.8)),
            window(ApproachSide::Top, 0.07, 0.02, Some(0.9)),
            window(ApproachSide::Top, 0.07, 0.03, Some(0.7)),
        ];
        let at = |width, from| {
            Window::for_width(&windows, width, from).map(|found| (found.position_m, found.yaw_rad))
        };
        assert_eq!(at(0.030, ApproachSide::Side), Some((0.01, None)));
        assert_eq!(at(0.0304, ApproachSide::Side), Some((0.01, None)), "the same width, but for rounding");
        assert_eq!(at(0.050, ApproachSide::Side), Some((0.01, Some(0.5))));
        assert_eq!(at(0.070, ApproachSide::Side), Some((0.03, Some(0.5))));
        assert_eq!(at(0.060, ApproachSide::Top), Some((0.04, Some(0.8))));
        assert_eq!(at(0.065, ApproachSide::Top), Some((0.02, Some(0.7))), "of two as wide the narrower");
        // A little beyond those that were simulated, and farther.
        assert_eq!(at(0.080, ApproachSide::Top), Some((0.02, Some(0.7))));
        assert_eq!(at(0.026, ApproachSide::Side), Some((0.01, None)));
        assert_eq!(
            (at(0.090, ApproachSide::Top), at(0.020, ApproachSide::Side), at(0.045, ApproachSide::Top)),
            (None, None, None)
        );
        assert_eq!(Window::for_width(&[], 0.05, ApproachSide::Top), None);
        let found = Window::for_width(&windows, 0.065, ApproachSide::Top).unwrap();
        assert_eq!((found.tilt_rad, found.force_n), (Some(0.35), Some(100.0 * 0.07)));
    }
}
