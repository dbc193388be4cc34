//! Recognises the grasp of a hand in a picture by an index of known views.
//!
//! In order of the data: [`picture`] decodes what a camera gives, [`segment`] finds the hand in it
//! (the paper's Section III), a [`Recogniser`] describes the hand, searches the index and lets the
//! neighbours vote (Sections IV and V), [`sequence`] and [`prior`] add what earlier frames and the
//! object say, and [`orientation`] puts the hand's rotation into words.
//!
//! Two features are off by default: `schema` describes the types that stand in records for OpenAPI,
//! and `landmarks` finds hands by MediaPipe's networks, which the user has as files.

mod accept;
mod context;
mod doubtful;
mod error;
mod evidence;
mod hypothesis;
#[cfg(feature = "landmarks")]
mod mediapipe;
pub mod networks;
mod options;
pub mod orientation;
pub mod picture;
pub mod prior;
pub mod ranges;
mod recogniser;
mod recognition;
pub mod scene;
pub mod segment;
pub mod sequence;
mod side;
mod source;
mod thorough;
mod timings;
mod tracker;
mod trust;
mod variant;
mod warning;

pub use accept::Doubt;
pub use error::{RecogniseError, SourceError};
pub use evidence::Evidence;
pub use hypothesis::Hypothesis;
#[cfg(feature = "landmarks")]
pub use mediapipe::{HandNetworks, HandNetworksError, NetworkFault};
pub use options::{Accept, DEFAULT_ROLLS, RecogniseOptions};
pub use recogniser::Recogniser;
pub use recognition::{Context, Recognition};
pub use side::{HandChoice, Side};
pub use source::{MaskSource, Prepared};
pub use timings::Timings;
pub use tracker::Tracker;
pub use trust::{Logistic, Term, Trust, logistic, temper};
pub use variant::Variant;
pub use warning::Warning;
