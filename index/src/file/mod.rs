//! The index file: written once, mapped read-only, never changed in place.
//!
//! ```text
//! header      64 bytes, little-endian: magic, versions, the file's length, where the catalogue lies, hashes   [header]
//! sections    plain arrays, each at a multiple of 64 bytes, zeros between                                     [sections]
//! catalogue   a small rkyv archive up to the end of the file: parameters, and where every section lies        [catalogue]
//! ```
//!
//! Opening reads the header, the catalogue and a network, where there is one, and no more
//! ([`open`]); hashing everything is for [`verify`]. Where another program changes it all the same,
//! [`stamp`] notices it, and [`fault`] keeps the reader alive.

mod align;
pub(crate) mod atomic;
pub(crate) mod bytes;
pub(crate) mod catalogue;
mod contents;
pub(crate) mod corruption;
pub(crate) mod error;
pub(crate) mod fault;
pub(crate) mod header;
pub(crate) mod input;
pub(crate) mod kept;
mod layout;
pub(crate) mod open;
pub(crate) mod pack;
pub(crate) mod sections;
pub(crate) mod stamp;
pub(crate) mod verify;
pub(crate) mod wire;
pub(crate) mod write;

// Sections are read in place as they lie in memory, and they lie in the file in little-endian
// order.
#[cfg(target_endian = "big")]
compile_error!("an index file is little-endian and read in place: big-endian machines are not supported");
