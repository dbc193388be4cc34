//! Where in space the pixels of a calibrated camera look.

use crate::messages::sensor::CameraInfo;

/// A camera without distortion, for pictures of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    /// In pixels, across and down.
    focal: [f64; 2],
    principal: [f64; 2],
    /// What a point's image is moved by, times its depth, in pixel metres: of a stereo pair's
    /// second camera, in whose pictures places are measured from the first one. 0 of any other.
    shift: [f64; 2],
}

impl View {
    /// The camera that a message describes, for pictures of `width` x `height` pixels: those of a
    /// camera whose driver shrinks them, or shows a part, are smaller than the message says. `None`
    /// where it is not calibrated.
    ///
    /// Rectified pictures are those of the camera P, all others of the camera K, whose distortion
    /// is not undone (`sensor_msgs/CameraInfo`). Where P has no focal length, as of drivers that
    /// fill in K alone, K is the nearest to it that there is.
    pub(crate) fn new(info: &CameraInfo, is_rectified: bool, [width, height]: [usize; 2]) -> Option<Self> {
        // A part of no size is all of it.
        let part = &info.roi;
        let is_whole = part.width == 0 || part.height == 0;
        let of_sensor = if is_whole { [info.width, info.height] } else { [part.width, part.height] };
        let offset = if is_whole { [0; 2] } else { [part.x_offset, part.y_offset] }.map(f64::from);
        let scale = |whole: u32, side: usize| if whole == 0 { 1.0 } else { side as f64 / f64::from(whole) };
        let (across, down) = (scale(of_sensor[0], width), scale(of_sensor[1], height));
        let [fx, _, cx, tx, _, fy, cy, ty, ..] = info.p;
        let projected = ([fx, fy], [cx, cy], [tx, ty]);
        let [fx, _, cx, _, fy, cy, ..] = info.k;
        let (focal, principal, shift) = match is_rectified && is_focal(projected.0) {
            true => projected,
            false => ([fx, fy], [cx, cy], [0.0; 2]),
        };
        let focal = [focal[0] * across, focal[1] * down];
        let principal = [(principal[0] - offset[0]) * across, (principal[1] - offset[1]) * down];
        let shift = [shift[0] * across, shift[1] * down];
        let is_sound = is_focal(focal) && principal.iter().chain(&shift).all(|place| place.is_finite());
        is_sound.then_some(Self { focal, principal, shift })
    }

    /// The point that is seen at a place of the picture, in pixels, as far in front of the camera
    /// as `depth` metres, in its optical frame.
    pub(crate) fn point(&self, place: [f64; 2], depth: f64) -> [f64; 3] {
        let along = |axis: usize| {
            ((place[axis] - self.principal[axis]) * depth - self.shift[axis]) / self.focal[axis]
        };
        [along(0), along(1), depth]
    }
}

fn is_focal(lengths: [f64; 2]) -> bool {
    lengths.iter().all(|length| length.is_finite() && *length > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::sensor::RegionOfInterest;

    fn info(k: [f64; 9]) -> CameraInfo {
        CameraInfo { width: 640, height: 480, k, ..CameraInfo::default() }
    }

    const K: [f64; 9] = [500.0, 0.0, 320.0, 0.0, 400.0, 240.0, 0.0, 0.0, 1.0];

    #[test]
    fn a_pixel_is_a_ray() {
        let view = View::new(&info(K), false, [640, 480]).unwrap();
        assert_eq!(view.point([320.0, 240.0], 0.8), [0.0, 0.0, 0.8]);
        assert_eq!(view.point([420.0, 140.0], 2.0), [0.4, -0.5, 2.0]);
    }

    #[test]
    fn a_shrunk_picture_is_seen_by_the_same_camera() {
        let (whole, half) = (
            View::new(&info(K), false, [640, 480]).unwrap(),
            View::new(&info(K), false, [320, 240]).unwrap(),
        );
        assert_eq!(half.point([210.0, 70.0], 1.0), whole.point([420.0, 140.0], 1.0));
    }

    #[test]
    fn a_part_of_a_picture_is_seen_by_the_same_camera() {
        let roi = RegionOfInterest {
            x_offset: 100,
            y_offset: 40,
            width: 320,
            height: 240,
            ..RegionOfInterest::default()
        };
        let part = CameraInfo { roi, ..info(K) };
        let whole = View::new(&info(K), false, [640, 480]).unwrap();
        let [cut, binned] = [1, 2].map(|by| View::new(&part, false, [320 / by, 240 / by]).unwrap());
        assert_eq!(cut.point([220.0, 160.0], 1.0), whole.point([320.0, 200.0], 1.0));
        assert_eq!(binned.point([110.0, 80.0], 1.0), whole.point([320.0, 200.0], 1.0));
    }

    #[test]
    fn a_camera_that_was_never_calibrated_sees_no_ray() {
        assert_eq!(View::new(&info([0.0; 9]), false, [640, 480]), None);
        assert_eq!(View::new(&info([f64::NAN; 9]), false, [640, 480]), None);
    }

    /// Of the first camera of a pair, whose distortion costs it some of its view.
    const P: [f64; 12] = [450.0, 0.0, 310.0, 0.0, 0.0, 360.0, 250.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    #[test]
    fn a_rectified_picture_is_seen_by_the_camera_p() {
        let both = CameraInfo { p: P, ..info(K) };
        let raw = View::new(&both, false, [640, 480]).unwrap();
        assert_eq!(raw, View::new(&info(K), false, [640, 480]).unwrap());
        let rectified = View::new(&both, true, [640, 480]).unwrap();
        assert_eq!(rectified.point([400.0, 286.0], 1.0), [0.2, 0.1, 1.0]);
        let half = View::new(&both, true, [320, 240]).unwrap();
        assert_eq!(half.point([200.0, 143.0], 1.0), rectified.point([400.0, 286.0], 1.0));
        // A driver that fills in K alone.
        assert_eq!(View::new(&info(K), true, [640, 480]).unwrap(), raw);
    }

    #[test]
    fn the_second_camera_of_a_pair_measures_from_the_first() {
        // 0.1 m to the right of it: what is straight ahead of the first one, 0.9 m away, is seen 50
        // pixels to the left.
        let mut second = CameraInfo { p: P, ..info(K) };
        second.p[3] = -450.0 * 0.1;
        let view = View::new(&second, true, [640, 480]).unwrap();
        let [x, y, z] = view.point([260.0, 250.0], 0.9);
        assert!(x.abs() < 1e-12 && y.abs() < 1e-12 && z == 0.9, "{x} {y} {z}");
    }
}
