//! What gives frame after frame: standard input, a file of frames, or a camera.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use grasp_answer::record::Record;
use grasp_recognise::RecogniseError;
use grasp_recognise::picture::DecodeError;
use grasp_terminal::text::counted;

use crate::live::camera::Camera;
use crate::live::{Ahead, EncodedFrame, Keep, STANDARD_INPUT, Source, SourceError};

/// The extensions of files that hold one frame after another.
const STREAMS: [&str; 3] = ["mjpg", "mjpeg", "y4m"];

/// Whether a name stands for frames instead of a picture: standard input, or a file of them.
pub(super) fn is_stream(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    path == Path::new(STANDARD_INPUT) || STREAMS.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// What gives frame after frame.
pub(super) enum Feed {
    /// What [`is_stream`].
    Stream(PathBuf),
    Camera(Camera),
}

impl Feed {
    /// The camera behind a device.
    pub(super) fn camera(device: &Path) -> anyhow::Result<Self> {
        Ok(Self::Camera(Camera::open(device)?))
    }

    /// What records call it.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Stream(path) => path.display().to_string(),
            Self::Camera(camera) => camera.path().display().to_string(),
        }
    }

    /// Gives `answer` each frame's number and the frame, or the record of why there is none.
    pub(super) fn each_frame(
        self,
        answer: impl FnMut(Option<u64>, Result<EncodedFrame, Record>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let name = self.name();
        match self {
            Self::Stream(path) => of_stream(&name, &path, answer),
            Self::Camera(camera) => of_camera(&name, camera, answer),
        }
    }
}

/// Each frame is answered as soon as it has come, and the next is awaited only then.
fn of_stream(
    name: &str,
    path: &Path,
    mut answer: impl FnMut(Option<u64>, Result<EncodedFrame, Record>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut source = Source::streams(vec![path.to_owned()]);
    let mut next = 0;
    while let Some(given) = source.next_frame() {
        // A picture alone is frame 0: whether another follows is not known yet.
        let number = Some(next);
        next += 1;
        let name = name.to_owned();
        answer(
            number,
            given.map_err(|error| match error {
                SourceError::Open { name: path, error: reason } => {
                    Record::not_recognised(name, None, &DecodeError::Read { path, reason }.into())
                }
                // The record names the file.
                SourceError::Stream { error, .. } => {
                    Record::failed(name, number, "stream", error.to_string())
                }
                other => Record::failed(name, number, other.kind(), other.to_string()),
            }),
        )?;
    }
    if next == 0 {
        let empty = RecogniseError::Decode(DecodeError::Empty);
        return answer(None, Err(Record::not_recognised(name.into(), None, &empty)));
    }
    Ok(())
}

/// A camera: the newest frame is answered, and those that came meanwhile are dropped.
fn of_camera(
    name: &str,
    camera: Camera,
    mut answer: impl FnMut(Option<u64>, Result<EncodedFrame, Record>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let ahead = Ahead::start(Source::Camera(camera), Keep::Newest).context("cannot read the camera")?;
    // Ctrl-C ends the program: each answer is written by then.
    let never = AtomicBool::new(false);
    while let Some(frame) = ahead.next_frame(&never) {
        let number = Some(frame.number);
        let failed =
            |error: SourceError| Record::failed(name.into(), number, error.kind(), error.to_string());
        answer(number, frame.given.map_err(failed))?;
    }
    if ahead.dropped() > 0 {
        let frames = counted(ahead.dropped(), ["frame", "frames"]);
        tracing::warn!(subject = name, "{frames} came faster than they were answered, and were dropped");
    }
    Ok(())
}
