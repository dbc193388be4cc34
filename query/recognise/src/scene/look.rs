//! Looks at squares of a picture.

use grasp_network::Scratch;

use super::square::{Square, Texels};
use crate::networks::{Heads, SIDE, SceneNetwork};
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
