//! Cuts a bare forearm off at the wrist.
//!
//! A descriptor of hand and forearm together describes mostly the forearm. The palm is where the
//! largest circle fits; the arm leaves from there to where the region crosses the picture's border;
//! the wrist is the narrowest place on that way. A region that does not reach the border ends at a
//! sleeve, or is a hand alone: it is left as it is.

use super::Mask;
use super::distance::Deepest;

/// Where the search for the wrist begins and ends, in radii of the palm's circle from its centre.
const SEARCH: std::ops::RangeInclusive<f32> = 1.0..=2.4;
/// An arm is at least this wide where it crosses the border, in radii of the palm; a finger is not.
const ARM_WIDTH: f32 = 0.7;

/// The largest circle inside a region: centre and radius in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle {
    x: f32,
    y: f32,
    radius: f32,
}

impl Circle {
    /// The largest one that fits a region with this deepest place.
    fn around(deepest: Deepest) -> Self {
        Self { x: deepest.x as f32, y: deepest.y as f32, radius: deepest.thirds as f32 / 3.0 }
    }
}

/// The region without its forearm; unchanged where no forearm leaves the picture.
///
/// `scale` is how many of the region's pixels one of `outline`'s spans: the wrist is looked for in
/// `outline`, the region itself or the same at a smaller size, whose deepest place is known.
pub(super) fn cut_at_wrist(region: &Mask, outline: &Mask, deepest: Option<Deepest>, scale: usize) -> Mask {
    let Some(cut) = deepest.and_then(|deepest| find_cut(outline, Circle::around(deepest))) else {
        return region.clone();
    };
    let (width, height) = (region.width(), region.height());
    let place = |at: usize| (at as f32 + 0.5) / scale.max(1) as f32 - 0.5;
    let across: Vec<f32> = (0..width).map(|x| (place(x) - cut.centre.x) * cut.axis.0).collect();
    let mut kept = region.pixels().to_vec();
    for (y, row) in kept.chunks_exact_mut(width.max(1)).enumerate() {
        let down = (place(y) - cut.centre.y) * cut.axis.1;
        for (kept, across) in row.iter_mut().zip(&across) {
            *kept &= u8::from(across + down <= cut.at);
        }
    }
    let kept = Mask::from_inside(width, height, kept);
    if kept.area() == 0 { region.clone() } else { kept }
}

/// A line across the arm: what lies farther than `at` along the arm's axis is forearm.
struct Cut {
    centre: Circle,
    axis: (f32, f32),
    at: f32,
}

impl Cut {
    fn along(&self, x: f32, y: f32) -> f32 {
        (x - self.centre.x) * self.axis.0 + (y - self.centre.y) * self.axis.1
    }

    fn across(&self, x: f32, y: f32) -> f32 {
        (y - self.centre.y) * self.axis.0 - (x - self.centre.x) * self.axis.1
    }
}

fn find_cut(region: &Mask, palm: Circle) -> Option<Cut> {
    let (exit_x, exit_y, exit_width) = widest_exit(region)?;
    if exit_width < ARM_WIDTH * palm.radius {
        return None;
    }
    let (dx, dy) = (exit_x - palm.x, exit_y - palm.y);
    let reach = libm::hypotf(dx, dy);
    let (nearest, farthest) = (SEARCH.start() * palm.radius, (SEARCH.end() * palm.radius).min(reach));
    if nearest + 2.0 > farthest {
        return None;
    }
    let mut cut = Cut { centre: palm, axis: (dx / reach, dy / reach), at: farthest };
    // Whole bins only: a bin that the search cuts in two would look narrow.
    let first = nearest.ceil() as usize;
    let mut widths = vec![0u32; (farthest as usize).saturating_sub(first)];
    for y in 0..region.height() {
        for x in 0..region.width() {
            let along = cut.along(x as f32, y as f32);
            let across = cut.across(x as f32, y as f32).abs();
            let on_arm = region.get(x, y) && along >= first as f32 && across <= 1.8 * palm.radius;
            let bin = (along.max(0.0) as usize).saturating_sub(first);
            if let Some(width) = widths.get_mut(bin).filter(|_| on_arm) {
                *width += 1;
            }
        }
    }
    // Three bins at a time: a line of pixels at an angle fills bins unevenly.
    let smooth = widths.windows(3).map(|three| three.iter().sum::<u32>());
    let (narrowest, _) = smooth.enumerate().min_by_key(|&(_, width)| width)?;
    cut.at = (first + narrowest + 1) as f32;
    Some(cut)
}

/// The longest run of region pixels on one side of the border: its middle and its length.
fn widest_exit(region: &Mask) -> Option<(f32, f32, f32)> {
    let (right, bottom) = (region.width().checked_sub(1)?, region.height().checked_sub(1)?);
    let longest = |length: usize, inside: &dyn Fn(usize) -> bool| {
        let (mut best, mut run) = ((0, 0), 0);
        for at in 0..length {
            run = if inside(at) { run + 1 } else { 0 };
            if run > best.1 {
                best = (at + 1 - run, run);
            }
        }
        (best.0 as f32 + (best.1 as f32 - 1.0) / 2.0, best.1 as f32)
    };
    let (across, down) = (region.width(), region.height());
    let (top, low) = (longest(across, &|x| region.get(x, 0)), longest(across, &|x| region.get(x, bottom)));
    let (left, far) = (longest(down, &|y| region.get(0, y)), longest(down, &|y| region.get(right, y)));
    [(top.0, 0.0, top.1), (low.0, bottom as f32, low.1), (0.0, left.0, left.1), (right as f32, far.0, far.1)]
        .into_iter()
        .filter(|exit| exit.2 > 0.0)
        .max_by(|a, b| a.2.total_cmp(&b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut_forearm(region: &Mask, outline: &Mask, scale: usize) -> Mask {
        cut_at_wrist(region, outline, Deepest::of(outline), scale)
    }

    /// A palm of radius 20 at (60, 50), a wrist 24 wide at x = 88, a forearm that widens to the
    /// right border or to `arm_end`.
    fn hand_and_arm(arm_end: usize) -> Mask {
        let (width, height) = (160, 100);
        let mut pixels = vec![false; width * height];
        for y in 0..height {
            for x in 0..width {
                let (dx, dy) = (x as f32 - 60.0, y as f32 - 50.0);
                let palm = dx.hypot(dy) <= 20.0;
                let half = 11.6 + (x as f32 - 88.0).abs() * 0.12;
                let arm = (60..arm_end).contains(&x) && dy.abs() <= half;
                let finger = (20..60).contains(&x) && (dy + 8.0).abs() <= 4.0;
                pixels[y * width + x] = palm || arm || finger;
            }
        }
        Mask::from_values(width, height, &pixels, |v| v)
    }

    #[test]
    fn a_bare_forearm_is_cut_near_the_narrowest_place() {
        let cut = cut_forearm(&hand_and_arm(160), &hand_and_arm(160), 1);
        let last = (0..160).rev().find(|&x| (0..100).any(|y| cut.get(x, y))).unwrap();
        assert!((82..=94).contains(&last), "cut at {last}");
        assert!(cut.get(22, 42), "the finger stays");
    }

    #[test]
    fn a_wrist_found_on_the_small_picture_is_cut_on_the_large_one() {
        let small = hand_and_arm(160);
        let large = small.resized(480, 300);
        let cut = cut_forearm(&large, &small, 3);
        assert!(cut.resized(160, 100).iou(&cut_forearm(&small, &small, 1)).unwrap() > 0.97);
    }

    #[test]
    fn an_arm_that_ends_at_a_sleeve_is_left_alone() {
        let region = hand_and_arm(120);
        assert_eq!(cut_forearm(&region, &region, 1), region);
    }

    #[test]
    fn the_largest_circle_of_a_disc_is_the_disc() {
        let circle = Circle::around(Deepest::of(&hand_and_arm(60)).unwrap());
        assert!((circle.x - 60.0).abs() <= 3.0 && (circle.y - 50.0).abs() <= 3.0, "{circle:?}");
        assert!((circle.radius - 20.0).abs() <= 2.0, "{circle:?}");
    }

    #[test]
    fn an_empty_mask_stays_empty() {
        let empty = Mask::from_values(5, 5, &[0u8; 25], |v| v == 1);
        assert_eq!(cut_forearm(&empty, &empty, 1), empty);
    }
}
