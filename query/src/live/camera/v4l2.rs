//! The ioctls, by `linuxvideo`.

use std::io;
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

use grasp_picture::yuyv_to_pnm;
use linuxvideo::format::{PixFormat, PixelFormat};
use linuxvideo::stream::ReadStream;
use linuxvideo::{BufType, BufTypes, Device, Fract};

use super::devices::devices_in;
use super::error::{CameraDevice, CameraError};

/// What a camera is asked for; it gives what of its own is nearest. More pixels are not worth their
/// time: hands are looked for at half that.
const SIZE: [u32; 2] = [640, 480];
/// Frames a second.
const RATE: u32 = 30;
/// Frames that a camera may spoil or leave empty, one behind the other, until it counts as broken.
const MOST_SPOILT: u32 = 100;

/// A camera that gives frames.
#[derive(Debug)]
pub struct Camera {
    path: PathBuf,
    /// `None` after an error.
    capture: Option<Capture>,
}

/// A device that is open.
struct Capture {
    stream: ReadStream,
    format: FrameFormat,
}

/// What a frame's bytes are.
#[derive(Clone, Copy, Debug)]
enum FrameFormat {
    /// A whole JPEG, whose Huffman tables may be left out.
    Jpeg,
    /// Uncompressed pairs of pixels.
    Yuyv { width: usize, height: usize, stride: usize },
}

impl std::fmt::Debug for Capture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.format)
    }
}

impl Camera {
    /// Opens a device and lets it give frames of 640 x 480 at 30 a second, or the nearest that it
    /// can.
    ///
    /// # Errors
    /// [`CameraError`]: there is no such camera, it is in use, or it gives no format that is read.
    pub fn open(path: &Path) -> Result<Self, CameraError> {
        let refused = |error| explain(path, error);
        let is_device = std::fs::metadata(path).map_err(refused)?.file_type().is_char_device();
        let not_one = || CameraError::NoCamera { path: path.to_owned(), found: cameras() };
        if !is_device {
            return Err(not_one());
        }
        let device = Device::open(path).map_err(|error| match error.raw_os_error() {
            // A device of another kind knows no such question.
            Some(libc::ENOTTY | libc::EINVAL) => not_one(),
            _ => refused(error),
        })?;
        if !device.supported_buf_types().contains(BufTypes::VIDEO_CAPTURE) {
            return Err(not_one());
        }
        let formats: Vec<PixelFormat> = device
            .formats(BufType::VIDEO_CAPTURE)
            .map_while(Result::ok)
            .map(|format| format.pixel_format())
            .collect();
        // Compressed, a camera gives more frames a second.
        let wanted = [PixelFormat::MJPG, PixelFormat::JPEG, PixelFormat::YUYV];
        let format = wanted.into_iter().find(|format| formats.contains(format)).ok_or_else(|| {
            let names =
                formats.iter().map(|format| String::from_utf8_lossy(&format.as_fourcc()).trim().to_owned());
            let names = names.collect::<Vec<_>>().join(", ");
            let formats = if names.is_empty() { "nothing that it names".to_owned() } else { names };
            CameraError::Formats { path: path.to_owned(), formats }
        })?;
        let capture = device.video_capture(PixFormat::new(SIZE[0], SIZE[1], format)).map_err(refused)?;
        // A camera that knows no rates has one.
        let _ = capture.set_frame_interval(Fract::new(1, RATE));
        let given = capture.format();
        let format = match given.pixel_format() {
            PixelFormat::MJPG | PixelFormat::JPEG => FrameFormat::Jpeg,
            PixelFormat::YUYV => FrameFormat::Yuyv {
                width: given.width() as usize,
                height: given.height() as usize,
                stride: given.bytes_per_line() as usize,
            },
            other => {
                let formats = String::from_utf8_lossy(&other.as_fourcc()).into_owned();
                return Err(CameraError::Formats { path: path.to_owned(), formats });
            }
        };
        let stream = capture.into_stream().map_err(refused)?;
        Ok(Self { path: path.to_owned(), capture: Some(Capture { stream, format }) })
    }

    /// Its device.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The next frame, encoded; `None` after an error.
    pub fn next_frame(&mut self) -> Option<Result<Vec<u8>, CameraError>> {
        let capture = self.capture.as_mut()?;
        let frame = capture.next_frame();
        if frame.is_err() {
            self.capture = None;
        }
        Some(frame.map_err(|error| CameraError::Failed { path: self.path.clone(), error }))
    }
}

impl Capture {
    fn next_frame(&mut self) -> io::Result<Vec<u8>> {
        let format = self.format;
        for _ in 0..MOST_SPOILT {
            // A frame that the driver calls spoilt, or that is empty, is none: the first ones of
            // some cameras are.
            let taken = self.stream.dequeue(|view| {
                let is_whole = !view.is_error() && !view.is_empty();
                Ok(if is_whole { encoded(format, &view) } else { None })
            });
            match taken {
                Ok(Some(frame)) => return Ok(frame),
                Ok(None) => {}
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("all its frames are empty or spoilt"))
    }
}

fn encoded(format: FrameFormat, frame: &[u8]) -> Option<Vec<u8>> {
    match format {
        FrameFormat::Jpeg => Some(frame.to_vec()),
        FrameFormat::Yuyv { width, height, stride } => {
            let packed = 4 * width.div_ceil(2);
            yuyv_to_pnm(width, height, stride.max(packed), frame)
        }
    }
}

/// The cameras that can be asked for pictures, and those that must not be opened.
fn cameras() -> Vec<CameraDevice> {
    let all = devices_in(Path::new("/dev"), Path::new("/sys/class/video4linux"));
    let captures = |camera: &CameraDevice| {
        Device::open(&camera.path)
            .map_or(true, |device| device.supported_buf_types().contains(BufTypes::VIDEO_CAPTURE))
    };
    all.into_iter().filter(captures).collect()
}

fn explain(path: &Path, error: io::Error) -> CameraError {
    let path: PathBuf = path.to_owned();
    match error.kind() {
        io::ErrorKind::NotFound => CameraError::Missing { path, found: cameras() },
        io::ErrorKind::PermissionDenied => CameraError::Forbidden(path),
        io::ErrorKind::ResourceBusy => CameraError::Busy(path),
        _ => match error.raw_os_error() {
            // Its node is there, and nothing behind it.
            Some(libc::ENXIO | libc::ENODEV) => CameraError::Missing { path, found: cameras() },
            _ => CameraError::Failed { path, error },
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_camera_is_told() {
        let told = |path: &str| Camera::open(Path::new(path)).unwrap_err();
        assert!(matches!(told("/dev/null"), CameraError::NoCamera { .. }), "{:?}", told("/dev/null"));
        assert!(matches!(told("/dev/video9999"), CameraError::Missing { .. }));
        assert!(matches!(told("/dev"), CameraError::NoCamera { .. }));
    }

    #[test]
    fn frames_are_encoded_as_pictures_that_can_be_read() {
        let format = FrameFormat::Yuyv { width: 4, height: 2, stride: 0 };
        let pnm = encoded(format, &[128; 16]).unwrap();
        let picture = grasp_recognise::picture::decode(&pnm).unwrap().picture;
        assert_eq!((picture.width(), picture.height(), picture.rgb()[7]), (4, 2, [130; 3]));
        assert_eq!(encoded(format, &[128; 15]), None);
        assert_eq!(encoded(FrameFormat::Jpeg, b"\xFF\xD8"), Some(b"\xFF\xD8".to_vec()));
    }
}
