//! From a hand image to a descriptor, of one of two kinds, which [`DescriptorParams`] names:
//!
//! - the embedding of a network, the default: [`planes`] makes its input, [`learned`] runs it;
//! - the paper's pyramid of histograms of gradient orientation (Section IV): [`gradient`] turns the
//!   picture into orientation (Equation 1), [`pyramid`] counts it over `4^(L-l)` cells a level `l`.
//!
//! [`Describer`] computes either. The parameters are recorded in the index, because descriptors
//! made with different ones cannot be compared.

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
