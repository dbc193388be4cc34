//! What stands for cameras where none are read.

use std::path::Path;

use super::error::CameraError;

/// A camera that there cannot be.
#[derive(Debug)]
pub enum Camera {}

impl Camera {
    /// Says that no cameras are read.
    ///
    /// # Errors
    /// [`CameraError::Unsupported`], always.
    pub fn open(_: &Path) -> Result<Self, CameraError> {
        Err(match () {
            () if cfg!(target_os = "macos") => {
                CameraError::Unsupported("cameras are read on Linux only", "avfoundation")
            }
            () if cfg!(target_os = "linux") => {
                CameraError::Unsupported("this program was built without the feature `camera`", "v4l2")
            }
            () => CameraError::Unsupported("cameras are read on Linux only", "dshow"),
        })
    }

    /// Its device.
    pub fn path(&self) -> &Path {
        match *self {}
    }

    /// The next frame, encoded; `None` after an error.
    pub fn next_frame(&mut self) -> Option<Result<Vec<u8>, CameraError>> {
        match *self {}
    }
}
