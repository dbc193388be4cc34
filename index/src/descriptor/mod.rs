//! From a hand image to a descriptor: a pyramid of histograms of gradient orientation (the paper's
//! Section IV).
//!
//! Two steps, one file each: [`gradient`] turns the picture into orientation (Equation 1),
//! [`pyramid`] counts it over `4^(L-l)` cells a level `l`. [`DescriptorParams`] says how both are
//! done; it is recorded in the index, because descriptors made with different parameters cannot be
//! compared.

mod cells;
mod describer;
mod gradient;
mod learned;
mod model;
mod params;
mod planes;
mod pyramid;
#[cfg(test)]
mod tests;

pub use cells::Cell;
pub use describer::Describer;
pub use learned::{NETWORK_STAGES, NetworkEstimate};
pub use model::DescriptorModel;
pub use params::{DescriptorKind, DescriptorParams, ParamsError, Sampling, Tone};
pub use planes::{PLANES_SIDE, PLANES_SOURCE_SIDE, Placement, SHOWN_LENGTHS, planes, shown};
