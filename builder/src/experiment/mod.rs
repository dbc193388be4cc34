//! Experiments: what the search does when something is varied, as tables and pictures.

pub mod scale;
pub mod shapes;
