//! Where frames come from.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::vec::IntoIter;

use grasp_recognise::picture::{DecodeError, DecodeWarning, Frame, Frames, StreamError};
use grasp_terminal::text::counted;

use super::camera::{Camera, CameraError};

/// The name of standard input, among files and in records.
pub const STANDARD_INPUT: &str = "-";

/// Why there is no next frame, or not this one.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A stream cannot be split.
    #[error("{}: {error}", name.display())]
    Stream {
        /// The file, `-` for standard input.
        name: PathBuf,
        /// What is wrong.
        error: StreamError,
    },
    /// A file cannot be opened.
    #[error("cannot read {}: {error}", name.display())]
    Open {
        /// The file.
        name: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// A file that pictures cannot be found in without a decoder of videos.
    #[error(
        "{file} is a video in a container, which is not read: let ffmpeg read it, `ffmpeg -i {file} -f mjpeg -q:v 3 - | grasp-query watch - --out OUT.mjpg`",
        file = .0.display()
    )]
    Container(PathBuf),
    /// The last frame of raw video is cut short: there is nothing to decode, and its record is that
    /// of an encoded picture that is cut short.
    #[error("{}", DecodeError::Truncated)]
    Cut(PathBuf),
    /// The camera gives no more.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

impl SourceError {
    /// The file, where it is about one.
    pub fn name(&self) -> Option<&Path> {
        match self {
            Self::Stream { name, .. } | Self::Open { name, .. } | Self::Container(name) | Self::Cut(name) => {
                Some(name)
            }
            Self::Camera(_) => None,
        }
    }

    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Camera(_) => "camera",
            Self::Cut(_) => DecodeError::Truncated.kind(),
            Self::Stream { .. } | Self::Open { .. } | Self::Container(_) => "stream",
        }
    }
}

/// An encoded frame of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedFrame {
    /// The file that it is from, `-` for standard input, or the camera's device.
    pub name: PathBuf,
    /// The encoded picture.
    pub bytes: Vec<u8>,
    /// How many bytes before it belong to no picture, and were skipped.
    pub skipped: u64,
}

impl EncodedFrame {
    /// What is odd about it, before it is decoded.
    pub fn warning(&self) -> Option<DecodeWarning> {
        (self.skipped > 0).then_some(DecodeWarning::Skipped { bytes: self.skipped })
    }
}

/// Where frames come from.
#[derive(Debug)]
pub enum Source {
    /// A camera.
    Camera(Camera),
    /// Pictures and streams of pictures in files, one file behind the other; `-` is standard input.
    Streams(Box<Streams>),
}

impl Source {
    /// The frames of these files, `-` being standard input.
    pub fn streams(files: Vec<PathBuf>) -> Self {
        Self::Streams(Box::new(Streams { files: files.into_iter(), current: None }))
    }

    /// Whether a file can be opened, and is none that only a decoder of videos reads. What is no
    /// regular file is not looked into: what is read of a pipe is gone.
    ///
    /// # Errors
    /// [`SourceError`], as reading the stream would give it.
    pub fn check(file: &Path) -> Result<(), SourceError> {
        let is_other = file == Path::new(STANDARD_INPUT) || file.metadata().is_ok_and(|data| !data.is_file());
        if is_other { Ok(()) } else { Input::open(file).map(drop) }
    }

    /// The next frame; `None` at the end. After an error of a camera there is none.
    pub fn next_frame(&mut self) -> Option<Result<EncodedFrame, SourceError>> {
        match self {
            Self::Camera(camera) => {
                let bytes = camera.next_frame()?;
                let given = |bytes| EncodedFrame { name: camera.path().to_owned(), bytes, skipped: 0 };
                Some(bytes.map(given).map_err(SourceError::from))
            }
            Self::Streams(streams) => streams.next_frame(),
        }
    }
}

/// Files, one behind the other.
#[derive(Debug)]
pub struct Streams {
    files: IntoIter<PathBuf>,
    current: Option<Stream>,
}

/// The file that is read.
#[derive(Debug)]
struct Stream {
    name: PathBuf,
    frames: Frames<Input>,
    /// It is raw video (YUV4MPEG2).
    is_raw: bool,
    /// It has given frames.
    has_begun: bool,
}

impl Streams {
    fn next_frame(&mut self) -> Option<Result<EncodedFrame, SourceError>> {
        loop {
            if let Some(stream) = &mut self.current {
                let name = stream.name.clone();
                match stream.frames.next() {
                    Some(Ok(Frame { bytes, skipped })) => {
                        stream.has_begun = true;
                        return Some(Ok(EncodedFrame { name, bytes, skipped }));
                    }
                    Some(Err(error)) => return Some(Err(SourceError::Stream { name, error })),
                    None => {
                        let rest = stream.rest();
                        self.current = None;
                        if let Err(cut) = rest {
                            return Some(Err(cut));
                        }
                    }
                }
            }
            let name = self.files.next()?;
            match Input::open(&name) {
                Ok(input) => {
                    let is_raw = input.is_raw();
                    self.current =
                        Some(Stream { name, frames: Frames::new(input), is_raw, has_begun: false });
                }
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

impl Stream {
    /// Reports what follows the last frame. In raw video that is the next frame, as far as it came.
    fn rest(&self) -> Result<(), SourceError> {
        let skipped = self.frames.skipped_at_end();
        if self.is_raw && skipped > 0 {
            return Err(SourceError::Cut(self.name.clone()));
        }
        if self.has_begun && skipped > 0 {
            let (subject, bytes) = (self.name.display().to_string(), counted(skipped, ["byte", "bytes"]));
            tracing::warn!(subject, skipped, "warning: {bytes} behind the last frame are no whole picture");
        }
        Ok(())
    }
}

/// What a stream is read from.
struct Input {
    /// What was read of it to see what it is; it is given first.
    start: io::Cursor<Vec<u8>>,
    rest: Rest,
}

/// What comes behind that.
enum Rest {
    Standard(io::Stdin),
    File(File),
}

/// How many bytes are read to see what a stream is.
const START: u64 = 12;
/// How raw video begins.
const RAW: &[u8] = b"YUV4MPEG2 ";

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.rest {
            Rest::Standard(_) => "standard input",
            Rest::File(_) => "a file",
        })
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let given = self.start.read(buffer)?;
        if given > 0 { Ok(given) } else { self.rest.read(buffer) }
    }
}

impl Read for Rest {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Standard(stdin) => stdin.read(buffer),
            Self::File(file) => file.read(buffer),
        }
    }
}

impl Input {
    fn open(name: &Path) -> Result<Self, SourceError> {
        let failed = |error| SourceError::Open { name: name.to_owned(), error };
        let mut rest = match name == Path::new(STANDARD_INPUT) {
            true => Rest::Standard(io::stdin()),
            false => Rest::File(File::open(name).map_err(failed)?),
        };
        let mut start = Vec::new();
        rest.by_ref().take(START).read_to_end(&mut start).map_err(failed)?;
        if matches!(rest, Rest::File(_)) && is_container(&start) {
            return Err(SourceError::Container(name.to_owned()));
        }
        Ok(Self { start: io::Cursor::new(start), rest })
    }

    fn is_raw(&self) -> bool {
        self.start.get_ref().starts_with(RAW)
    }
}

/// Whether a file begins as MP4 and QuickTime, Matroska and WebM, or AVI do.
fn is_container(start: &[u8]) -> bool {
    let at = |from: usize, bytes: &[u8]| start.get(from..).is_some_and(|rest| rest.starts_with(bytes));
    at(4, b"ftyp") || at(0, &[0x1A, 0x45, 0xDF, 0xA3]) || (at(0, b"RIFF") && at(8, b"AVI "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PNM: &[u8] = b"P5 1 1 255\n.";

    fn all(source: &mut Source) -> Vec<Result<EncodedFrame, String>> {
        std::iter::from_fn(|| source.next_frame())
            .take(20)
            .map(|frame| frame.map_err(|error| error.to_string().replace('\\', "/")))
            .collect()
    }

    #[test]
    fn files_give_their_frames_one_behind_the_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("one.pgm"), PNM).unwrap();
        std::fs::write(path("two.bin"), [PNM, b"..", PNM].concat()).unwrap();
        std::fs::write(path("clip.mp4"), b"\0\0\0\x20ftypisom").unwrap();
        let files = ["two.bin", "none.mjpg", "clip.mp4", "one.pgm"].map(path).to_vec();
        let frames = all(&mut Source::streams(files));
        let frame = |name: &str, skipped| Ok(EncodedFrame { name: path(name), bytes: PNM.to_vec(), skipped });
        assert_eq!(frames.len(), 5, "{frames:?}");
        assert_eq!(frames[..2], [frame("two.bin", 0), frame("two.bin", 2)]);
        assert_eq!(frames[4], frame("one.pgm", 0));
        let told = |at: usize| frames[at].as_ref().unwrap_err();
        assert!(told(2).contains("cannot read ") && told(2).contains("none.mjpg"), "{}", told(2));
        assert!(told(3).contains("clip.mp4 is a video in a container"), "{}", told(3));
    }

    #[test]
    fn a_last_frame_of_raw_video_that_is_cut_short_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let whole = b"YUV4MPEG2 W2 H1 Cmono\nFRAME\n..FRAME\n..";
        for (name, missing, expected) in [("whole.y4m", 0, 2), ("cut.y4m", 1, 1), ("begun.y4m", 6, 1)] {
            std::fs::write(path(name), &whole[..whole.len() - missing]).unwrap();
            std::fs::write(path("one.pgm"), PNM).unwrap();
            let mut source = Source::streams([name, "one.pgm"].map(path).to_vec());
            let frames: Vec<_> = std::iter::from_fn(|| source.next_frame()).collect();
            let (last, frames) = frames.split_last().unwrap();
            assert_eq!(last.as_ref().unwrap().name, path("one.pgm"), "{name}: the next file is read");
            assert_eq!(frames.iter().filter(|frame| frame.is_ok()).count(), expected, "{name}");
            let cut = frames.iter().filter_map(|frame| frame.as_ref().err());
            let told: Vec<_> = cut.map(|error| (error.kind(), error.name())).collect();
            let expected = (missing > 0).then(|| ("truncated", Some(path(name))));
            let expected: Vec<_> = expected.iter().map(|(kind, name)| (*kind, name.as_deref())).collect();
            assert_eq!(told, expected, "{name}");
        }
    }
}
