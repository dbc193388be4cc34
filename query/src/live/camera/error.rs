//! Why a camera gives no frames.

use std::io;
use std::path::PathBuf;

use grasp_terminal::text::printable;

/// Why a camera gives no frames.
#[derive(Debug, thiserror::Error)]
pub enum CameraError {
    /// There is no such device.
    #[error("there is no camera {}: {}", path.display(), devices_in_words(found))]
    Missing {
        /// The device.
        path: PathBuf,
        /// The cameras that there are.
        found: Vec<CameraDevice>,
    },
    /// It must not be opened.
    #[error(
        "the camera {} must not be read by this user: `sudo usermod -aG video $USER` lets it, from the next login on",
        .0.display()
    )]
    Forbidden(PathBuf),
    /// Another program has it.
    #[error("the camera {} is in use by another program: close that first", .0.display())]
    Busy(PathBuf),
    /// It is a device that gives no pictures.
    #[error("{} is no camera that gives pictures: {}", path.display(), devices_in_words(found))]
    NoCamera {
        /// The device.
        path: PathBuf,
        /// The cameras that there are.
        found: Vec<CameraDevice>,
    },
    /// It gives pictures in other formats only.
    #[error(
        "the camera {camera} gives neither MJPG nor YUYV, but {formats}: let ffmpeg read it, `ffmpeg -f v4l2 -i {camera} -f mjpeg - | grasp-query recognise -`",
        camera = path.display()
    )]
    Formats {
        /// The device.
        path: PathBuf,
        /// What it gives.
        formats: String,
    },
    /// It stopped, or refused something.
    #[error("the camera {} gives no more frames: {error}", path.display())]
    Failed {
        /// The device.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// This program reads no cameras.
    #[error("{0}: let ffmpeg read the camera, `ffmpeg -f {1} -i NAME -f mjpeg - | grasp-query recognise -`")]
    Unsupported(&'static str, &'static str),
}

/// A camera of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraDevice {
    /// Its device.
    pub path: PathBuf,
    /// What its driver calls it.
    pub name: String,
}

pub(super) fn devices_in_words(found: &[CameraDevice]) -> String {
    if found.is_empty() {
        return "no camera is connected; pictures, and streams of them, can be read from files and `-`"
            .into();
    }
    let each = found.iter().map(|camera| format!("{} ({})", camera.path.display(), printable(&camera.name)));
    format!("there are {}", each.collect::<Vec<_>>().join(", "))
}
