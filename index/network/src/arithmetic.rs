//! What a network is computed in.

/// What a network is computed in. Its outputs differ by it a little, and so it is part of a network
/// and of its file: descriptors of either kind are not compared with those of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// Single precision.
    Floats,
    /// Integers of 8 bits, as a [`QuantisedNetwork`](crate::QuantisedNetwork).
    Integers,
}
