//! Which of the simulated windows counts for an object, and what is left of it.

use super::attitude::Attitude;
use super::window::Window;

/// Beyond the thinnest and the widest object that were simulated a window is taken over as far as
/// this: to a hand that is turned 30 degrees too far a round thing looks 15 % wider than it is.
const BEYOND: f64 = 1.2;
/// Widths that differ by less are the same, in metres.
const SAME: f64 = 1e-3;

/// Why no window counts.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoWindow {
    /// The grasp was simulated with nothing.
    Never,
    /// The hand comes from below, or from where none came.
    Side,
    /// Nothing lay so to the palm.
    Attitude,
    /// Nothing as thin or as wide was simulated.
    Width,
    /// The hand is tilted or turned farther than is tolerated: by so much, and so much would be, in
    /// radians.
    Off {
        /// In a sentence: `tilted`, or `turned`.
        how: &'static str,
        /// How far it is.
        by: f64,
        /// How far it may be.
        most: f64,
    },
}

/// The one of `windows` that counts for an object as wide as `width`, in metres, that lies so
/// to the hand: between two objects that were simulated, the narrower of theirs, and the
/// greater force; less what the hand's own tilt and turn use up of it.
///
/// # Errors
/// [`NoWindow`]: where none such was simulated, or nothing is left of it.
pub(super) fn applicable(
    windows: &[Window],
    width: f64,
    attitude: Option<&Attitude>,
) -> Result<Window, NoWindow> {
    if windows.is_empty() {
        return Err(NoWindow::Never);
    }
    let attitude = attitude
        .filter(|attitude| windows.iter().any(|window| window.from == attitude.from))
        .ok_or(NoWindow::Side)?;
    let comparable: Vec<(&Window, Window)> =
        windows.iter().filter_map(|window| Some((window, attitude.left_of(window)?))).collect();
    if comparable.is_empty() {
        return Err(NoWindow::Attitude);
    }
    let widths = || comparable.iter().map(|(window, _)| window.width_m);
    let thinner = widths().filter(|other| *other <= width + SAME).reduce(f64::max);
    let wider = widths().filter(|other| *other >= width - SAME).reduce(f64::min);
    let is_beyond = match (thinner, wider) {
        (None, Some(wider)) => wider > BEYOND * width,
        (Some(thinner), None) => width > BEYOND * thinner,
        _ => false,
    };
    let near = || comparable.iter().filter(|(window, _)| [thinner, wider].contains(&Some(window.width_m)));
    let narrowest = near().min_by(|(a, _), (b, _)| a.position_m.total_cmp(&b.position_m));
    let Some((narrowest, _)) = narrowest.filter(|_| !is_beyond) else { return Err(NoWindow::Width) };
    let narrower = |how: &'static str, angle: fn(&Window) -> Option<f64>| {
        let angles = near().filter_map(|(window, left)| Some((angle(window)?, angle(left)?)));
        match angles.min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            Some((most, left)) if left <= 0.0 => Err(NoWindow::Off { how, by: most - left, most }),
            found => Ok(found.map(|(_, left)| left)),
        }
    };
    let tilt_rad = narrower("tilted", |window| window.tilt_rad)?;
    let yaw_rad = narrower("turned", |window| window.yaw_rad)?;
    let roll_rad = narrower("turned about its approach", |window| window.roll_rad)?;
    let force_n = near().filter_map(|(window, _)| window.force_n).reduce(f64::max);
    Ok(Window { yaw_rad, tilt_rad, roll_rad, force_n, ..(*narrowest).clone() })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion, Vector3};

    use super::*;
    use crate::{ApproachSide, Shape};

    /// Of a ball to a hand that comes exactly from there, or tilted by so much, in radians.
    fn ball(from: ApproachSide, tilt: f64) -> Option<Attitude> {
        let palm = from.turned() * UnitQuaternion::new(Vector3::y() * tilt);
        Attitude::new(&palm, &Shape::Sphere { radius: 0.03 }, &Isometry3::identity())
    }

    fn window(from: ApproachSide, width_m: f64, position_m: f64, yaw_rad: Option<f64>) -> Window {
        let (object, engine) = (format!("{width_m}"), "none".into());
        let tilt_rad = yaw_rad.map(|yaw| 0.5 * yaw);
        Window {
            position_m,
            yaw_rad,
            tilt_rad,
            roll_rad: None,
            force_n: Some(100.0 * width_m),
            object,
            width_m,
            from,
            axis: None,
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
            let found = applicable(&windows, width, ball(from, 0.0).as_ref()).ok();
            found.map(|found| (found.position_m, found.yaw_rad))
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
        let top = |tilt| ball(ApproachSide::Top, tilt);
        assert_eq!(applicable(&[], 0.05, top(0.0).as_ref()), Err(NoWindow::Never));
        assert_eq!(applicable(&windows, 0.05, None), Err(NoWindow::Side));
        let found = applicable(&windows, 0.065, top(0.0).as_ref()).unwrap();
        assert!((found.tilt_rad.unwrap() - 0.35).abs() < 1e-9 && found.force_n == Some(100.0 * 0.07));
        // What a tilt uses up is gone; two thirds of it, and more than there is.
        let found = applicable(&windows, 0.065, top(0.25).as_ref()).unwrap();
        assert!((found.tilt_rad.unwrap() - 0.10).abs() < 1e-9 && found.yaw_rad == Some(0.7));
        let Err(NoWindow::Off { how, by, most }) = applicable(&windows, 0.065, top(-0.4).as_ref()) else {
            panic!("a tilt of 0.4 is tolerated")
        };
        assert!(how == "tilted" && (by - 0.4).abs() < 1e-9 && (most - 0.35).abs() < 1e-9);
    }
}
