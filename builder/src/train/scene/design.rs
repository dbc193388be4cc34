//! The layers of a network that looks at scenes.

use grasp_network::{Architecture, Convolution, Masks};
use grasp_renders::Part;

/// Pixels a side of the input.
pub(super) const SIDE: usize = 64;

/// Kernel, stride and outputs of each convolution.
type Convolutions = &'static [(u32, u32, u32)];

const NAMING: Convolutions = &[
    (5, 2, 16),
    (3, 2, 32),
    (3, 1, 40),
    (3, 2, 96),
    (3, 1, 104),
    (3, 1, 104),
    (3, 2, 160),
    (3, 1, 160),
    (3, 1, 176),
];
const CUTTING: Convolutions = &[
    (5, 2, 24),
    (3, 2, 48),
    (3, 1, 64),
    (3, 1, 64),
    (3, 1, 64),
    (3, 1, 64),
    (3, 1, 64),
    (3, 1, 64),
    (3, 1, 64),
    (3, 2, 64),
    (3, 2, 96),
];

/// What the layers are best at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Design {
    /// To name what is seen, by ever coarser layers: 30 million multiply-adds. Masks are coarse.
    Naming,
    /// To cut it out: most of its 69 million multiply-adds are layers of a quarter of the picture's
    /// resolution, which see nearly all of it, and from which its masks are read.
    Cutting,
}

impl Design {
    /// Values a side of the masks.
    pub(super) fn mask_side(self) -> usize {
        match self {
            Self::Naming => SIDE / 2,
            Self::Cutting => SIDE,
        }
    }

    /// The architecture, whose heads have `heads` values.
    pub(super) fn architecture(self, heads: usize) -> Architecture {
        let (layers, read_off, embedding) = match self {
            Self::Naming => (NAMING, 5, 128),
            Self::Cutting => (CUTTING, 8, 64),
        };
        let convolution = |&(kernel, stride, outputs)| Convolution { kernel, stride, outputs };
        Architecture {
            side: SIDE as u32,
            planes: 3,
            convolutions: layers.iter().map(convolution).collect(),
            embedding,
            heads: heads as u32,
            masks: Some(Masks { convolution: read_off, count: Part::ALL.len() as u32, cells: 4 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_have_the_side_that_lessons_have() {
        for design in [Design::Naming, Design::Cutting] {
            let architecture = design.architecture(17);
            assert_eq!(architecture.mask_side(), Ok(design.mask_side()));
            assert_eq!(SIDE % design.mask_side(), 0);
        }
    }
}
