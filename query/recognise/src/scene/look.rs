//! Looks at squares of a picture.

use grasp_network::Scratch;

use super::square::{Square, Texels};
use crate::networks::{Heads, SIDE, SceneNetwork};
use crate::picture::Picture;
use crate::segment::Mask;

/// The networks' input: a square of one picture, sampled.
pub(super) struct SquareInput<'a> {
    pub(super) picture: &'a Picture,
    texels: Texels,
    scratch: Scratch,
    /// The square's planes.
    planes: Vec<f32>,
}

impl<'a> SquareInput<'a> {
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

    /// Samples a square.
    pub(super) fn sample(&mut self, square: &Square) {
        square.planes(&self.texels, SIDE, &mut self.planes);
    }

    /// Makes the square its mirror image.
    pub(super) fn mirror(&mut self) {
        self.planes.chunks_exact_mut(3 * SIDE).for_each(|row| row.as_chunks_mut::<3>().0.reverse());
    }

    /// What a network makes of the square that was sampled.
    pub(super) fn run(&mut self, network: &SceneNetwork) -> Heads {
        network.run(&mut self.scratch, &self.planes)
    }

    /// What a network makes of a square.
    pub(super) fn run_on(&mut self, network: &SceneNetwork, square: &Square) -> Heads {
        self.sample(square);
        self.run(network)
    }
}
