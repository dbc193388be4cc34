//! Cameras, by Video4Linux.
//!
//! On other systems, and in a program that was built without the feature `camera`, opening one is
//! an error that says what to do instead.

mod devices;
#[cfg(not(all(target_os = "linux", feature = "camera")))]
mod elsewhere;
mod error;
#[cfg(all(target_os = "linux", feature = "camera"))]
mod v4l2;

pub use devices::device;
#[cfg(not(all(target_os = "linux", feature = "camera")))]
pub use elsewhere::Camera;
pub use error::{CameraDevice, CameraError};
#[cfg(all(target_os = "linux", feature = "camera"))]
pub use v4l2::Camera;
