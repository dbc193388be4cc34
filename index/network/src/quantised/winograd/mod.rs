//! Convolutions of 3 x 3 by fewer products: Winograd's minimal filtering F(2 x 2, 3 x 3), in
//! integers (A. Lavin and S. Gray, "Fast Algorithms for Convolutional Neural Networks", CVPR 2016).
//!
//! A tile of 2 x 2 outputs reads a window of 4 x 4 inputs. Window and kernel are transformed into 16
//! values each, sums and differences of their own; products of the same place are summed over the
//! input planes; and the 16 sums are transformed into the tile's outputs. These are 16 products a
//! plane where the windows of the four outputs have 36. In integers all of this is exact: the bits
//! are those of the convolution window by window.
//!
//! Transformed values have up to 12 bits: this is for paths that sum products of words.
//! Instructions that sum those of bytes do twice as many at once, and would gain little.

mod kernel;
mod layout;
mod transform;

#[cfg(target_arch = "x86_64")]
pub(super) use kernel::pairs_256;
pub(super) use kernel::{compute, pairs};
pub(super) use layout::Winograd;
