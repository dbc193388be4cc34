//! The offline half: pictures of hands in, one index file out.
//!
//! `grasp-builder` has a small library so that its parts can be read and tested by themselves:
//!
//! - [`indexing`] turns render sets, or hand shapes rendered on the fly, into an index, and takes
//!   over from an existing index whatever has not changed;
//! - [`shard`] makes one part of an index on one of many machines, and [`merge`] the index of all
//!   parts;
//! - [`mod@split`] writes an index as several that are searched as one;
//! - [`grow`] adds to an index, removes from it, and joins several;
//! - [`experiment`] varies something and measures what the search does;
//! - [`train`] trains the network of a learned descriptor, and [`descriptor`] names the
//!   descriptors;
//! - [`plan_spec`] is what an index keeps of how its hands are posed and seen;
//! - [`cli`] is the command line, one file a subcommand;
//! - [`interrupt`] lets long work be stopped.
//!
//! What a hand looks like is `grasp-renders`' business; what an index is, `grasp-index`'.

mod array;
pub mod cli;
pub mod descriptor;
pub mod experiment;
pub mod export;
pub mod grow;
pub mod held_out;
pub mod indexing;
pub mod interrupt;
pub mod merge;
mod open_sound;
pub mod plan_spec;
mod same_file;
pub mod shard;
pub mod split;
pub mod train;
