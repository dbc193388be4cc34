//! Trials of a grasp in a physics engine (rapier3d), with a model of the BarrettHand.

mod barrett;
mod drive;
mod film;
mod quality;
mod scenes;
mod trial;
mod world;

pub use film::Film;
pub use quality::Quality;
pub use scenes::{SCENES, Scene};
pub use trial::{Offset, Outcome, Plan};
