//! Answers as a person reads them and as a program does.

pub mod found;
pub mod human;
pub mod moveit;
pub mod record;
