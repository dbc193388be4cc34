//! A stream of pictures on one pipe, split into its frames.
//!
//! Read are encoded pictures one behind the other (`ffmpeg -f image2pipe -c:v mjpeg`, or `ppm`, or
//! `png`), the parts of an HTTP `multipart/x-mixed-replace` response as network cameras send it,
//! and YUV4MPEG2 (`ffmpeg -f yuv4mpegpipe`). Where a frame ends is found from the format alone,
//! without decoding. A frame is given as soon as its last byte has come, and at most one is held in
//! memory.

mod end;
mod error;
mod multipart;
mod y4m;

use std::io::{self, Read};

use end::{End, Kind, LONGEST_SIGNATURE, Scan};
use error::MAX_FRAME_BYTES;
pub use error::{StreamError, Y4mFault};
use multipart::PartHeader;
use y4m::Y4m;

/// How much is asked of the pipe at once.
const CHUNK: usize = 64 * 1024;

/// One picture of a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The encoded picture; a frame of YUV4MPEG2 as a PNM.
    pub bytes: Vec<u8>,
    /// How many bytes before it belong to no picture, and were skipped.
    pub skipped: u64,
}

/// Splits a byte stream into the encoded pictures in it.
///
/// PNM (binary: P4, P5, P6, P7), JPEG, PNG, BMP and WebP frames are told apart by their first
/// bytes. Behind the first frame, what belongs to none is skipped up to the next of the same
/// format; zeros are skipped before the first, too. Other bytes at the stream's beginning are one
/// picture up to its end, and so is a last frame that is cut short: decoding then reports what is
/// wrong.
#[derive(Debug)]
pub struct Frames<R> {
    input: R,
    buffer: Vec<u8>,
    scan: Scan,
    /// The format of the frame before.
    last: Option<Kind>,
    y4m: Option<Y4m>,
    skipped: u64,
    ended: bool,
    failed: bool,
}

impl<R: Read> Frames<R> {
    /// Splits what `input` gives.
    pub fn new(input: R) -> Self {
        Self {
            input,
            buffer: Vec::new(),
            scan: Scan::default(),
            last: None,
            y4m: None,
            skipped: 0,
            ended: false,
            failed: false,
        }
    }

    /// How many bytes behind the last frame belong to no picture.
    pub fn skipped_at_end(&self) -> u64 {
        self.skipped
    }

    /// Takes what the pipe has ready: waiting for a full chunk would hold a live camera's frame
    /// back.
    fn read_more(&mut self) -> Result<(), StreamError> {
        let held = self.buffer.len();
        self.buffer.resize(held + CHUNK, 0);
        let read = loop {
            match self.input.read(&mut self.buffer[held..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                outcome => break outcome,
            }
        };
        self.buffer.truncate(held + *read.as_ref().unwrap_or(&0));
        self.ended = read? == 0;
        Ok(())
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, StreamError> {
        loop {
            // Behind the frames of one such stream another may begin, as `cat` puts them together.
            if let Some(header) = y4m::header(&self.buffer) {
                let (y4m, length) = header?;
                self.take(length);
                self.y4m = Some(y4m);
                continue;
            }
            if let Some(y4m) = &self.y4m {
                match y4m.end_of_frame(&self.buffer) {
                    End::At(end) if end <= self.buffer.len() => {
                        let y4m = y4m.clone();
                        let bytes = self.take(end);
                        return Ok(Some(self.frame(y4m.to_pnm(&bytes))));
                    }
                    End::Unknown => return Err(StreamError::Y4m(Y4mFault::NoFrame)),
                    // A last frame that is cut short has no rows of colour.
                    _ if self.ended => {
                        self.skip(self.buffer.len());
                        return Ok(None);
                    }
                    _ => {}
                }
            } else if let Some(kind) = Kind::of(&self.buffer) {
                match kind.end(&self.buffer, &mut self.scan) {
                    End::At(end) if end <= self.buffer.len() => {
                        self.last = Some(kind);
                        let bytes = self.take(end);
                        return Ok(Some(self.frame(bytes)));
                    }
                    End::TooLarge => return Err(StreamError::TooLarge),
                    _ if self.ended => return Ok(self.rest()),
                    _ => {}
                }
            } else if !self.between_frames()? {
                if self.ended {
                    return Ok(self.rest());
                }
            } else {
                continue;
            }
            if self.buffer.len() > MAX_FRAME_BYTES {
                return Err(StreamError::TooLarge);
            }
            self.read_more()?;
        }
    }

    /// Takes what stands where a frame should begin and is none. `false` where more bytes are
    /// needed to tell, or where all that follows is one picture.
    fn between_frames(&mut self) -> Result<bool, StreamError> {
        match multipart::header(&self.buffer) {
            PartHeader::Whole(length) => {
                self.take(length);
                return Ok(true);
            }
            PartHeader::NeedsMore if !self.ended => return Ok(false),
            // The closing boundary.
            PartHeader::NeedsMore => {
                self.take(self.buffer.len());
                return Ok(false);
            }
            PartHeader::None => {}
        }
        let zeros = self.buffer.iter().take_while(|&&byte| byte == 0).count();
        let behind = self.buffer.get(zeros..).unwrap_or_default();
        // A few zeros at the beginning may be a format's own.
        let are_between = self.last.is_some()
            || zeros >= LONGEST_SIGNATURE
            || Kind::of(behind).is_some()
            || y4m::begins(behind);
        if zeros > 0 && are_between {
            self.skip(zeros);
            return Ok(true);
        }
        let Some(last) = self.last else { return Ok(false) };
        // Any format may begin with what has come.
        if self.buffer.len() < LONGEST_SIGNATURE && !self.ended {
            return Ok(false);
        }
        let next = last.find(&self.buffer);
        self.skip(next);
        Ok(next > 0)
    }

    /// All that is left, as the last frame.
    fn rest(&mut self) -> Option<Frame> {
        let length = self.buffer.len();
        if length == 0 {
            return None;
        }
        if self.last.is_some() && Kind::of(&self.buffer).is_none() {
            self.skip(length);
            return None;
        }
        let bytes = self.take(length);
        Some(self.frame(bytes))
    }

    fn frame(&mut self, bytes: Vec<u8>) -> Frame {
        Frame { bytes, skipped: std::mem::take(&mut self.skipped) }
    }

    fn skip(&mut self, length: usize) {
        self.take(length);
        self.skipped += length as u64;
    }

    fn take(&mut self, end: usize) -> Vec<u8> {
        self.scan = Scan::default();
        let rest = self.buffer.split_off(end);
        std::mem::replace(&mut self.buffer, rest)
    }
}

impl<R: Read> Iterator for Frames<R> {
    type Item = Result<Frame, StreamError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let frame = self.next_frame().transpose();
        self.failed = matches!(frame, Some(Err(_)));
        frame
    }
}
