//! Answers as a person reads them and as a program does.

pub mod human;
pub mod record;
pub mod view;
