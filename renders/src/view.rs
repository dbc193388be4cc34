//! Where the camera stands, and what that means as a rotation.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::random::between;

/// One camera direction, in degrees.
///
/// The camera stands in the direction (azimuth, elevation) from the hand's centre, in `world` (z
/// up), and looks at that centre. Azimuth 0 is the side to which the hand's x axis points, 90 is a
/// quarter turn counter-clockwise seen from above. Without roll the picture's upper edge is up in
/// the world; a positive roll turns the camera about its optical axis so that the picture's content
/// turns counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// 0 up to 360.
    pub azimuth_deg: f64,
    /// -90 (from below) to 90 (from above).
    pub elevation_deg: f64,
    /// 0 up to 360.
    pub roll_deg: f64,
}

impl View {
    /// A view drawn from all rotations alike, to a tenth of a degree.
    pub fn random(rng: &mut ChaCha8Rng) -> View {
        let tenths = |degrees: f64| (degrees * 10.0).round() / 10.0;
        // Equal heights of a sphere have equal areas.
        let elevation = libm::asin(between(rng, [-1.0, 1.0]));
        View {
            azimuth_deg: tenths(between(rng, [0.0, 359.9])),
            elevation_deg: tenths(elevation.to_degrees()),
            roll_deg: tenths(between(rng, [0.0, 359.9])),
        }
    }

    /// The rotation from `world` into the camera's optical frame (z forward, x right, y down).
    pub fn camera_from_world(&self) -> UnitQuaternion<f64> {
        let (sin_a, cos_a) = libm::sincos(self.azimuth_deg.to_radians());
        let (sin_e, cos_e) = libm::sincos(self.elevation_deg.to_radians());
        let forward = Vector3::new(-cos_e * cos_a, -cos_e * sin_a, -sin_e);
        // `forward` cross `up`, written out so that it also holds straight from above and below.
        let right = Vector3::new(-sin_a, cos_a, 0.0);
        let down = forward.cross(&right);
        let rows = Matrix3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
        let level = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows));
        let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -self.roll_deg.to_radians());
        roll * level
    }
}

/// How the hand is held: the rotation from the hand's frame into `world`, given which of its
/// directions points up. The hand's x axis points to azimuth 0 (its z axis, should x itself point
/// up or down).
pub fn world_from_hand(up: &Vector3<f64>) -> UnitQuaternion<f64> {
    let level = |v: Vector3<f64>| (v - up * up.dot(&v)).try_normalize(1e-3);
    let x = level(Vector3::x()).or_else(|| level(Vector3::z())).unwrap_or_else(Vector3::x);
    let y = up.cross(&x);
    let rows = Matrix3::from_rows(&[x.transpose(), y.transpose(), up.transpose()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows))
}

/// Which camera directions a plan takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Views {
    /// The same directions for every scene, in equal steps.
    Grid(ViewGrid),
    /// So many directions for every scene, other ones for each, drawn from all rotations alike: any
    /// azimuth, elevation and roll. As many scenes then cover the rotations more densely than any
    /// grid of the same number would.
    Random(usize),
}

impl Views {
    /// How many views a scene has.
    pub fn count(&self) -> usize {
        match self {
            Views::Grid(grid) => grid.views().len(),
            Views::Random(count) => *count,
        }
    }
}

/// Camera directions in equal steps.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewGrid {
    /// Step of azimuth and elevation in degrees.
    pub step_deg: f64,
    /// Lowest and highest elevation in degrees; the highest is left out when a step does not meet
    /// it.
    pub elevation_deg: [f64; 2],
    /// Rolls in degrees.
    pub rolls_deg: Vec<f64>,
}

impl Default for ViewGrid {
    /// The paper's half-sphere: 60 azimuths x 15 elevations (0 to 84 degrees) in steps of 6
    /// degrees.
    fn default() -> ViewGrid {
        ViewGrid { step_deg: 6.0, elevation_deg: [0.0, 84.0], rolls_deg: vec![0.0] }
    }
}

impl ViewGrid {
    /// All views: elevation by elevation, azimuth by azimuth, roll by roll.
    ///
    /// A grid whose step is not a positive number or whose range is empty has none.
    pub fn views(&self) -> Vec<View> {
        let [low, high] = self.elevation_deg;
        if !(self.step_deg > 0.0 && low <= high) {
            return Vec::new();
        }
        // A hair more, so that 84 / 6 is 14 whole steps.
        let steps = |span: f64| (span / self.step_deg + 1e-6).floor() as usize;
        let azimuths = (360.0 / self.step_deg - 1e-6).ceil().max(1.0) as usize;
        let mut views = Vec::new();
        for e in 0..=steps(high - low) {
            for a in 0..azimuths {
                for &roll_deg in &self.rolls_deg {
                    views.push(View {
                        azimuth_deg: a as f64 * self.step_deg,
                        elevation_deg: low + e as f64 * self.step_deg,
                        roll_deg,
                    });
                }
            }
        }
        views
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn see(view: View, p: Vector3<f64>) -> Vector3<f64> {
        view.camera_from_world() * p
    }

    fn view(azimuth_deg: f64, elevation_deg: f64, roll_deg: f64) -> View {
        View { azimuth_deg, elevation_deg, roll_deg }
    }

    fn close(a: Vector3<f64>, b: Vector3<f64>) -> bool {
        (a - b).norm() < 1e-12
    }

    #[test]
    fn known_points_from_known_places() {
        // From the front (azimuth 0): what is nearer to the camera is behind the centre, up is -y.
        assert!(close(see(view(0.0, 0.0, 0.0), Vector3::x()), -Vector3::z()));
        assert!(close(see(view(0.0, 0.0, 0.0), Vector3::z()), -Vector3::y()));
        assert!(close(see(view(0.0, 0.0, 0.0), Vector3::y()), Vector3::x()));
        // From above: the hand's x axis, toward azimuth 0, points down in the picture.
        assert!(close(see(view(0.0, 90.0, 0.0), Vector3::x()), Vector3::y()));
        assert!(close(see(view(0.0, 90.0, 0.0), Vector3::z()), -Vector3::z()));
        // A roll of a quarter turn: up moves to the left.
        assert!(close(see(view(0.0, 0.0, 90.0), Vector3::z()), -Vector3::x()));
    }

    #[test]
    fn a_bottle_is_held_with_the_thumb_up() {
        let turn = world_from_hand(&Vector3::y());
        assert!(close(turn * Vector3::y(), Vector3::z()));
        assert!(close(turn * Vector3::x(), Vector3::x()));
        let upright = world_from_hand(&Vector3::x());
        assert!(close(upright * Vector3::x(), Vector3::z()));
    }

    #[test]
    fn the_papers_grid_has_900_views() {
        let views = ViewGrid::default().views();
        assert_eq!(views.len(), 900);
        assert_eq!(views[899], view(354.0, 84.0, 0.0));
        let none = ViewGrid { step_deg: 0.0, ..ViewGrid::default() };
        assert!(none.views().is_empty());
        let whole = ViewGrid { step_deg: 12.0, elevation_deg: [-84.0, 84.0], rolls_deg: vec![0.0, 90.0] };
        assert_eq!(whole.views().len(), 30 * 15 * 2);
    }

    proptest! {
        #[test]
        fn the_camera_looks_at_the_centre(a in 0.0..360.0f64, e in -90.0..90.0f64, r in 0.0..360.0f64) {
            let v = view(a, e, r);
            let (ar, er) = (a.to_radians(), e.to_radians());
            let ((sin_a, cos_a), (sin_e, cos_e)) = (libm::sincos(ar), libm::sincos(er));
            let stand = Vector3::new(cos_e * cos_a, cos_e * sin_a, sin_e);
            prop_assert!(close(see(v, stand), -Vector3::z()));
            let level = see(view(a, e, 0.0), Vector3::z());
            prop_assert!(level.x.abs() < 1e-12 && level.y <= 0.0, "up is up in the picture");
        }
    }
}
