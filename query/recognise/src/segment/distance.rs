//! How far each pixel is from a set of pixels: the chamfer distance with steps 3 and 4 (Borgefors
//! 1986).

use super::Mask;

/// A distance that no picture reaches.
const FAR: u32 = u32::MAX / 2;

/// Thirds of a pixel from each pixel of a picture, `width` x `height`, to the nearest that is
/// `in_set`.
///
/// With `beyond`, what lies outside the picture is in the set as well; without it and without any
/// pixel in the set, all distances are huge.
pub(super) fn thirds(width: usize, height: usize, in_set: impl Fn(usize) -> bool, beyond: bool) -> Vec<u32> {
    // A frame of one pixel saves the border's special cases.
    let stride = width + 2;
    let outside = if beyond { 0 } else { FAR };
    let mut framed = vec![outside; stride * (height + 2)];
    for y in 0..height {
        let row = &mut framed[(y + 1) * stride + 1..][..width];
        for (x, distance) in row.iter_mut().enumerate() {
            *distance = if in_set(y * width + x) { 0 } else { FAR };
        }
    }
    for y in 1..=height {
        let (above, here) = framed.split_at_mut(y * stride);
        step_across(&above[(y - 1) * stride..], &mut here[1..=width]);
        step_along(here[..=width].iter_mut());
    }
    for y in (1..=height).rev() {
        let (here, below) = framed.split_at_mut((y + 1) * stride);
        let here = &mut here[y * stride + 1..];
        step_across(&below[..stride], &mut here[..width]);
        step_along(here.iter_mut().rev());
    }
    let mut distances = Vec::with_capacity(width * height);
    for row in framed.chunks_exact(stride).skip(1).take(height) {
        distances.extend_from_slice(&row[1..=width]);
    }
    distances
}

/// Steps from the row before into this one, straight and diagonal. `before` has a pixel more at
/// either end.
fn step_across(before: &[u32], here: &mut [u32]) {
    let [left, straight, right] = [0, 1, 2].map(|first| &before[first..first + here.len()]);
    for (((here, left), straight), right) in here.iter_mut().zip(left).zip(straight).zip(right) {
        *here = (*here).min(straight + 3).min(left.min(right) + 4);
    }
}

/// Steps from each pixel of a row to the next one.
fn step_along<'a>(mut row: impl Iterator<Item = &'a mut u32>) {
    let Some(mut before) = row.next().copied() else { return };
    for here in row {
        before = (*here).min(before + 3);
        *here = before;
    }
}

/// The place in a mask that is farthest from its outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Deepest {
    /// Column and row in pixels; of several places, the first.
    pub(super) x: usize,
    /// See [`Self::x`].
    pub(super) y: usize,
    /// Thirds of a pixel to the nearest that is outside.
    pub(super) thirds: u32,
}

impl Deepest {
    /// Beyond the picture counts as outside, so that an arm cut by the border does not pass for a
    /// palm. `None` where nothing is inside.
    pub(super) fn of(mask: &Mask) -> Option<Self> {
        let (width, pixels) = (mask.width(), mask.pixels());
        let distances = thirds(width, mask.height(), |at| pixels[at] == 0, true);
        let (at, &thirds) = distances.iter().enumerate().rev().max_by_key(|&(_, &distance)| distance)?;
        (thirds > 0).then_some(Self { x: at % width, y: at / width, thirds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_shortest_way_in_steps_of_three_and_four(
            (width, height, set) in crate::segment::tests_support::masks(),
        ) {
            let found = thirds(width, height, |at| set[at], false);
            for (at, &found) in found.iter().enumerate() {
                let nearest = (0..set.len()).filter(|&other| set[other]).map(|other| {
                    let dx = (other % width).abs_diff(at % width) as u32;
                    let dy = (other / width).abs_diff(at / width) as u32;
                    3 * dx.max(dy) + dx.min(dy)
                });
                prop_assert!(nearest.min().map_or(found >= FAR, |nearest| nearest == found));
            }
        }
    }

    #[test]
    fn beyond_the_picture_may_count() {
        assert_eq!(thirds(3, 3, |_| false, true), [3, 3, 3, 3, 6, 3, 3, 3, 3]);
    }
}
