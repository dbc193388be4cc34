//! What every drawing here is made of. One look with the drawings of `grasp-builder experiment`:
//! white ground, thin grey axes, and colours that the colour-blind tell apart.

mod axes;
mod drawing;

pub(super) use axes::{Axes, Axis};
#[cfg(test)]
pub(super) use drawing::tests;
pub(super) use drawing::{Anchor, COLOURS, FAINT, GREY, Svg, WIDTH};
