//! A small convolutional network: from a picture of a hand to an embedding, whose nearest
//! neighbours name the grasp, and to masks where it has been trained to answer with some.
//!
//! This crate runs a network and reads and writes its weights; it does not train. One input has one
//! output, to the last bit, on every processor: a descriptor that was computed here can be compared
//! with one from another machine, and a rebuilt index has the same bytes.
//!
//! In integers of 8 bits a network is computed up to four times as fast, with nearly the same
//! output: a [`Network`] whose file says so ([`Arithmetic`]), or any as a [`QuantisedNetwork`].
//!
//! ```
//! use grasp_network::{Architecture, Convolution, Network, Scratch};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let architecture = Architecture {
//!     side: 8,
//!     planes: 2,
//!     convolutions: vec![Convolution { kernel: 3, stride: 2, outputs: 4 }],
//!     embedding: 16,
//!     heads: 6,
//!     masks: None,
//! };
//! let weights = vec![0.1; architecture.parameters()?];
//! let network = Network::from_weights(architecture, weights)?;
//!
//! // One scratch for each thread, used again for each picture.
//! let mut scratch = Scratch::default();
//! let output = network.run(&mut scratch, &[0.5; 8 * 8 * 2]);
//! assert_eq!((output.embedding.len(), output.heads.len()), (16, 6));
//!
//! let copy = Network::from_bytes(&network.to_bytes())?;
//! assert_eq!(copy.fingerprint(), network.fingerprint());
//! # Ok(())
//! # }
//! ```

mod architecture;
mod arithmetic;
mod buffers;
mod file;
mod kernel;
mod lanes;
mod layer;
mod masks;
mod network;
mod output;
mod packed;
mod path;
mod pixels;
mod quantised;
mod scratch;
mod supported;
mod unpacked;
mod weights;

pub use architecture::{Architecture, Convolution};
pub use arithmetic::Arithmetic;
pub use file::ReadError;
pub use layer::{Layer, Rectifier};
pub use masks::Masks;
pub use network::Network;
pub use output::Output;
pub use path::Path;
pub use quantised::QuantisedNetwork;
pub use scratch::Scratch;
pub use supported::ArchitectureError;
pub use weights::WeightsError;
