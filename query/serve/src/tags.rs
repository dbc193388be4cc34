//! The tags of the paths, in the order of the page for people.

pub(super) const PICTURES: &str = "Pictures";
pub(super) const DESCRIPTORS: &str = "Descriptors";
pub(super) const INDEX: &str = "The index";
pub(super) const OPERATION: &str = "Operation";
