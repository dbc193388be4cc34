//! Looks at squares of a picture.

use grasp_network::Scratch;

use super::network::{Heads, SIDE, SceneNetwork};
use super::square::{Square, Texels};
use crate::picture::Picture;
use crate::segment::Mask;

/// An eye on one picture, through which networks look.
pub(super) struct Eye<'a> {
    pub(super) picture: &'a Picture,
    texels: Texels,
    scratch: Scratch,
    /// The square that it is turned to, as the networks are shown it.
    planes: Vec<f32>,
}

/// The patch of cells in which a mask found a part, in shares of the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patch {
    pub(super) centre: [f64; 2],
    /// The share of the square's area.
    pub(super) area: f64,
}

impl<'a> Eye<'a> {
    pub(super) fn new(picture: &'a Picture) -> Self {
        Self::of_texels(picture, Texels::of(picture))
    }

    /// The same of a hand that is cut out: all else is black.
    pub(super) fn of_cut_out(picture: &'a Picture, hand: &Mask) -> Self {
        Self::of_texels(picture, Texels::of_cut_out(picture, hand))
    }

    fn of_texels(picture: &'a Picture, texels: Texels) -> Self {
        Self { picture, texels, scratch: Scratch::default(), planes: Vec::new() }
    }

    /// Turns to a square.
    pub(super) fn turn_to(&mut self, square: &Square) {
        square.planes(&self.texels, SIDE, &mut self.planes);
    }

    /// Makes what it is turned to its mirror image.
    pub(super) fn mirror(&mut self) {
        self.planes.chunks_exact_mut(3 * SIDE).for_each(|row| row.as_chunks_mut::<3>().0.reverse());
    }

    /// What a network makes of what it is turned to.
    pub(super) fn see(&mut self, network: &SceneNetwork) -> Heads {
        network.run(&mut self.scratch, &self.planes)
    }

    /// What a network makes of a square.
    pub(super) fn look(&mut self, network: &SceneNetwork, square: &Square) -> Heads {
        self.turn_to(square);
        self.see(network)
    }
}

/// The largest patch of one of the masks; `None` where none is above its half.
pub(super) fn largest_patch(mask: &[f32], side: usize) -> Option<Patch> {
    let mut seen = vec![false; mask.len()];
    let mut best: Option<Patch> = None;
    let mut stack = Vec::new();
    for start in 0..mask.len() {
        stack.push(start);
        let (mut sum, mut count) = ([0usize; 2], 0usize);
        while let Some(at) = stack.pop() {
            if seen[at] || mask[at] <= 0.0 {
                continue;
            }
            seen[at] = true;
            let (x, y) = (at % side, at / side);
            sum = [sum[0] + x, sum[1] + y];
            count += 1;
            let beside = [(x > 0, at.wrapping_sub(1)), (x + 1 < side, at + 1)];
            let above = [(y > 0, at.wrapping_sub(side)), (y + 1 < side, at + side)];
            stack.extend(
                beside.into_iter().chain(above).filter(|(is_inside, _)| *is_inside).map(|(_, to)| to),
            );
        }
        let area = count as f64 / mask.len() as f64;
        if count > 0 && best.is_none_or(|patch| area > patch.area) {
            let centre = sum.map(|sum| (sum as f64 / count as f64 + 0.5) / side as f64);
            best = Some(Patch { centre, area });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_patch_is_found_with_its_middle() {
        let side = 8;
        let mut mask = vec![-1.0; side * side];
        for at in [0, 1, 8 * 4 + 4, 8 * 4 + 5, 8 * 5 + 4, 8 * 5 + 5, 8 * 7 + 7] {
            mask[at] = 2.0;
        }
        let patch = largest_patch(&mask, side).unwrap();
        assert_eq!(patch, Patch { centre: [5.0 / 8.0, 5.0 / 8.0], area: 4.0 / 64.0 });
        assert_eq!(largest_patch(&[-1.0; 4], 2), None);
    }
}
