//! Recognises the grasp of a hand in a picture by an index of known views.
//!
//! In order of the data: [`picture`] decodes what a camera gives, [`segment`] finds the hand in it (the paper's
//! Section III), [`recognise`] describes the hand, searches the index and lets the neighbours vote (Sections IV and
//! V), [`sequence`] and [`prior`] add what earlier frames and the object say, [`output`] writes the answer as text or JSON Lines, [`explain`] draws how it came about, and [`evaluate`]
//! scores labelled pictures, of which [`experiment`] makes the tables and drawings of Section VII, and
//! [`quiz`] asks a person the same. [`robot`] makes a strategy for a robot hand of the answer (Section VI). [`search`] takes raw
//! descriptors instead of pictures. [`cli`] puts them behind the program `grasp-query`.

pub mod cli;
pub mod client;
pub mod evaluate;
pub mod experiment;
pub mod explain;
mod lettering;
pub mod output;
pub mod picture;
pub mod prior;
pub mod quiz;
pub mod recognise;
pub mod robot;
pub mod search;
pub mod segment;
pub mod sequence;
pub mod serve;
