//! What an index makes of somebody's own labelled pictures, as one page that needs nothing else:
//! figures with their intervals, drawings, and the pictures that tell most.

mod accuracy;
mod findings;
mod page;
mod plot;
mod shelf;
mod thumbnail;

pub use accuracy::Accuracy;
pub use findings::{Findings, Source, Speed};
pub use shelf::{Shelf, Shelves, Shown};
