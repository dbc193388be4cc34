//! Where frames and records go.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_answer::human;
use grasp_answer::record::Record;
use grasp_index::AtomicFile;
use image::RgbImage;
use image::codecs::jpeg::JpegEncoder;

/// JPEG's quality: that of a video that is looked at, and written in time.
const QUALITY: u8 = 85;
/// Extensions of videos in a container.
const CONTAINERS: [&str; 6] = ["mp4", "m4v", "mov", "avi", "mkv", "webm"];
/// What stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// A frame as a JPEG.
pub(super) fn encoded(drawing: &RgbImage) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(128 * 1024);
    drawing
        .write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, QUALITY))
        .context("a frame cannot be encoded")?;
    Ok(bytes)
}

/// Where something goes.
enum Sink {
    /// Standard output, which others read as it comes.
    Standard(io::Stdout),
    /// A file that is there once it is whole, and its path.
    File(BufWriter<AtomicFile>, PathBuf),
}

impl Sink {
    fn new(path: &Path) -> anyhow::Result<Self> {
        Ok(match path == Path::new(STANDARD_OUTPUT) {
            true => Self::Standard(io::stdout()),
            false => Self::File(BufWriter::new(AtomicFile::create(path)?), path.to_owned()),
        })
    }

    fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        match self {
            // Without a context: who closes a pipe is recognised by the error itself.
            Self::Standard(out) => Ok(out.write_all(bytes).and_then(|()| out.flush())?),
            Self::File(out, path) => out.write_all(bytes).with_context(|| cannot_write(path)),
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        if let Self::File(out, path) = self {
            let out = out.into_inner().map_err(io::IntoInnerError::into_error);
            out.with_context(|| cannot_write(&path))?.commit()?;
        }
        Ok(())
    }
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Where frames and records go.
pub(super) struct Output {
    frames: Sink,
    /// Whether a frame was written.
    has_frames: bool,
    /// Records as JSON Lines.
    records: Option<Sink>,
    /// What was last printed as text, where there is neither JSON nor a video on standard output:
    /// the grasp, or why there is none.
    printed: Option<String>,
}

impl Output {
    /// Begins to write.
    pub(super) fn new(frames: &Path, records: Option<&Path>) -> anyhow::Result<Self> {
        if records == Some(frames) {
            bail!(
                "frames and records cannot both go to {}: name a file for one, as in --json=FILE",
                frames.display()
            );
        }
        let extension = frames.extension().unwrap_or_default();
        if CONTAINERS.iter().any(|known| extension.eq_ignore_ascii_case(known)) {
            let out = frames.display();
            bail!(
                "frames are written as MJPEG, which {out} would not be: name it .mjpg, or let ffmpeg make it, `grasp-query watch ... --out - | ffmpeg -f mjpeg -i - {out}`"
            );
        }
        let frames_sink = Sink::new(frames)?;
        let records = records.map(Sink::new).transpose()?;
        Ok(Self { frames: frames_sink, has_frames: false, records, printed: None })
    }

    /// Writes a frame, where there is anything to see, and its record.
    pub(super) fn write(&mut self, record: &Record, frame: Option<&[u8]>) -> anyhow::Result<()> {
        if let Some(frame) = frame {
            self.frames.write(frame)?;
            self.has_frames = true;
        }
        match &mut self.records {
            Some(records) => {
                let mut line = serde_json::to_vec(record).map_err(io::Error::from)?;
                line.push(b'\n');
                records.write(&line)?;
            }
            None => self.print_change(record)?,
        }
        Ok(())
    }

    /// Prints a frame whose grasp is not that of the frame before.
    fn print_change(&mut self, record: &Record) -> io::Result<()> {
        let (what, of) = match record {
            Record::Answer(answer) => (answer.grasp.clone(), human::name(&answer.file, answer.frame)),
            Record::Failure(failure) => {
                (failure.error.message.clone(), human::name(&failure.file, failure.frame))
            }
        };
        if self.printed.as_ref() == Some(&what) {
            return Ok(());
        }
        let probability = match record {
            Record::Answer(answer) if answer.cutkosky.is_some() => format!(", {:.2}", answer.probability),
            _ => String::new(),
        };
        let line = grasp_terminal::text::printable_lines(&format!("{of}: {what}{probability}\n"));
        self.printed = Some(what);
        // Standard output is the video where that goes there.
        match &self.frames {
            Sink::Standard(_) => io::stderr().write_all(line.as_bytes()).or(Ok(())),
            Sink::File(..) => {
                let mut out = io::stdout();
                out.write_all(line.as_bytes()).and_then(|()| out.flush())
            }
        }
    }

    /// Puts the records' file in its place where the frames went to standard output, as far as
    /// those were written.
    pub(super) fn keep_records(self) -> anyhow::Result<()> {
        match (self.frames, self.records) {
            (Sink::Standard(_), Some(records)) => records.finish(),
            _ => Ok(()),
        }
    }

    /// Puts the files in their place. A video without a frame is none: what lies in its place may
    /// be one.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        match &self.frames {
            Sink::File(_, path) if !self.has_frames => {
                let subject = path.display().to_string();
                tracing::warn!(subject, "not written: there was no frame to draw on");
            }
            _ => self.frames.finish()?,
        }
        self.records.map(Sink::finish).transpose()?;
        Ok(())
    }
}
