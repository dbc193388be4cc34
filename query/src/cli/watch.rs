//! `grasp-query watch`.

mod output;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context as _, bail};
use grasp_answer::annotate::{Annotator, FrameContent};
use grasp_answer::human;
use grasp_answer::record::Record;
use grasp_recognise::picture::{self, Decoded};
use grasp_recognise::sequence::Filter;
use grasp_recognise::{Recogniser, Tracker};
use grasp_terminal::text::counted;

use super::answering::Answering;
use super::index_file::IndexFile;
use super::options::{FrameArguments, RecogniseArguments};
use super::outputs::refuse_overwriting_by_any;
use super::pictures::pictures;
use super::robot::RobotArguments;
use crate::live::camera::{self, Camera};
use crate::live::{Ahead, EncodedFrame, Frame, Keep, Pace, Source};
use grasp_program::status::{INTERRUPTED, SUCCESS};
use output::Output;

const EXAMPLES: &str = "\
Examples:
  grasp-query watch tests/pictures/camera --switch 1 --out seen.mjpg --json
                                                         pictures of different hands, each by itself
  grasp-query watch tests/pictures/camera/01-large-diameter.jpg --out seen.mjpg --robot barrett \\
    --object query/data/objects/bottle.toml --camera query/data/objects/camera.toml
  grasp-query watch --camera 0 --out seen.mjpg           a camera, until Ctrl-C
  ffmpeg -i VIDEO.mp4 -f mjpeg -q:v 3 - | grasp-query watch - --out - | ffmpeg -f mjpeg -i - OUT.mp4
                                                         a video, and a video of it
  grasp-query watch --camera 0 --out - | ffplay -f mjpeg -
                                                         a camera, in a window

Exit status: 0 all frames recognised, 1 some frame was rejected or unknown, 2 an error, 130 stopped
by Ctrl-C.";

/// Draw the answers into the frames of a video or of a camera: the hand's outline and axes, the
/// grasp, and how probable each was over time.
///
/// The frames are those of one hand, in their order: each is answered by all so far, as `recognise
/// --sequence` does, and the hand is looked for first where it was in the frame before.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Watch {
    /// The frames: streams as `recognise` reads them (JPEG, PNG or PNM one behind the other, HTTP
    /// multipart MJPEG, YUV4MPEG2) in files, or `-` for standard input; pictures; a folder stands
    /// for the pictures in it; or a camera's number or device.
    #[arg(required_unless_present = "cameras", value_name = "SOURCE")]
    sources: Vec<PathBuf>,
    /// Write the frames that were drawn into this file, JPEG behind JPEG, or `-` for standard
    /// output.
    #[arg(long, value_name = "OUT.mjpg")]
    out: PathBuf,
    /// Print JSON Lines, one record a frame, or write them into a file (--json=FILE).
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-")]
    json: Option<PathBuf>,
    /// The frames cannot wait: while one is looked at, only the newest of those that come is kept.
    /// Always on for the device of a camera.
    #[arg(long)]
    live: bool,
    /// Say at the end how long a frame took, and in each record how long each step took.
    #[arg(long)]
    timings: bool,
    #[command(flatten)]
    index: IndexFile,
    #[command(flatten)]
    robot: RobotArguments,
    #[command(flatten)]
    recognise: RecogniseArguments,
    #[command(flatten)]
    frames: FrameArguments,
}

/// Set by the first SIGINT or SIGTERM.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// What is known from frame to frame, and what every frame is answered with.
struct Watching<'a> {
    answering: Answering<'a>,
    tracker: Tracker,
    filter: Filter,
    annotator: Annotator,
    pace: Pace,
    /// What records call the source of the frame at hand.
    name: String,
}

impl Watch {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        let (source, keep) = self.source()?;
        let robot = self.robot.read()?;
        let index = self.index.open_for_pictures()?;
        let mut watching = Watching {
            answering: Answering {
                recogniser: Recogniser::new(&index, self.recognise.options()?),
                robot,
                timings: self.timings,
            },
            tracker: Tracker::default(),
            filter: Filter::new(self.frames.params(), None),
            annotator: Annotator::new(&index),
            pace: Pace::default(),
            name: self.named(),
        };
        let mut output = Output::new(&self.out, self.json.as_deref())?;
        // The frames so far are kept; a second signal ends the program at once.
        ctrlc::set_handler(|| {
            if STOPPED.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(INTERRUPTED));
            }
        })
        .context("cannot listen for Ctrl-C")?;
        let ahead = Ahead::start(source, keep).context("cannot read frames")?;
        let mut status = SUCCESS;
        while let Some(frame) = ahead.next_frame(&STOPPED) {
            let (record, drawing) = watching.frame(frame)?;
            self.index.check(&index)?;
            status = status.max(record.status());
            if let Err(error) = output.write(&record, drawing.as_deref()) {
                // Who closes the window that shows the frames keeps their records.
                output.keep_records()?;
                return Err(error);
            }
        }
        let was_stopped = STOPPED.load(Ordering::Relaxed);
        if watching.pace.frames() == 0 && !was_stopped {
            bail!("{} holds no frame: give pictures, or a stream of them", self.named());
        }
        output.finish()?;
        self.sum_up(&watching, ahead.dropped());
        // Who watches a camera ends that by Ctrl-C.
        Ok(if was_stopped && keep == Keep::All { INTERRUPTED } else { status })
    }

    /// The source as messages call it.
    fn named(&self) -> String {
        match (self.sources.as_slice(), self.robot.device()) {
            ([only], _) => only.display().to_string(),
            ([first, others @ ..], _) => format!("{} and {} more", first.display(), others.len()),
            ([], Ok(Some(device))) => device.display().to_string(),
            ([], _) => "nothing".to_owned(),
        }
    }

    /// What gives the frames, and whether it can wait.
    fn source(&self) -> anyhow::Result<(Source, Keep)> {
        let by_option = self.robot.device()?.map(Path::to_owned);
        let by_name = match self.sources.as_slice() {
            [only] if !only.exists() || is_device(only) => only.to_str().and_then(camera::device),
            _ => None,
        };
        if let (Some(device), [_, ..]) = (&by_option, self.sources.as_slice()) {
            bail!("the frames are those of the camera {}: leave out SOURCE", device.display());
        }
        if let Some(device) = by_option.or(by_name) {
            self.refuse_overwriting(&[])?;
            return Ok((Source::Camera(Camera::open(&device)?), Keep::Newest));
        }
        if self.sources.is_empty() {
            bail!("name a video, or a camera by its number, as in --camera 0");
        }
        let files = pictures(&self.sources)?;
        files.iter().try_for_each(|file| Source::check(file))?;
        self.refuse_overwriting(&files)?;
        let keep = if self.live { Keep::Newest } else { Keep::All };
        Ok((Source::streams(files), keep))
    }

    fn refuse_overwriting(&self, read: &[PathBuf]) -> anyhow::Result<()> {
        let index = self.index.path();
        let outs = [Some(&self.out), self.json.as_ref()].into_iter().flatten();
        let inputs = read.iter().map(PathBuf::as_path).chain([index.as_path()]);
        refuse_overwriting_by_any(outs.map(PathBuf::as_path), inputs)
    }

    fn sum_up(&self, watching: &Watching<'_>, dropped: u64) {
        if dropped > 0 {
            let frames = counted(dropped, ["frame", "frames"]);
            let subject = self.named();
            tracing::warn!(subject, dropped, "{frames} came faster than they were drawn, and were dropped");
        }
        if self.timings {
            let frames = counted(watching.pace.frames(), ["frame", "frames"]);
            let searches = counted(watching.tracker.searches(), ["time", "times"]);
            tracing::info!("{frames}; {}", watching.pace);
            tracing::info!("the hand was looked for in the whole picture {searches}");
        }
    }
}

/// Whether a path is a device, as cameras are.
fn is_device(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        path.metadata().is_ok_and(|metadata| metadata.file_type().is_char_device())
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

impl Watching<'_> {
    /// Answers a frame and draws it, as a JPEG, once a picture was there to draw on.
    fn frame(&mut self, frame: Frame) -> anyhow::Result<(Record, Option<Vec<u8>>)> {
        let number = frame.number;
        let name = match &frame.given {
            Ok(given) => Some(given.name.as_path()),
            Err(error) => error.name(),
        };
        if let Some(name) = name {
            self.name = name.display().to_string();
        }
        let warning = frame.given.as_ref().ok().and_then(EncodedFrame::warning);
        let started = Instant::now();
        let decoded = self.decoded(frame);
        let decode = started.elapsed();
        let shown = decoded.as_ref().ok().map(|decoded| decoded.picture.clone());
        let found = decoded.and_then(|decoded| {
            let decode_ms = 1e3 * decode.as_secs_f64();
            let found = self.answering.recogniser.recognise_next(decoded, decode_ms, &mut self.tracker);
            found.map_err(|error| Record::not_recognised(self.name.clone(), Some(number), &error))
        });
        let (record, found) = match found {
            Ok(mut found) => {
                let filter = Some(&mut self.filter);
                (self.answering.record(&self.name, Some(number), &mut found, filter), Some(found))
            }
            Err(record) => {
                // Time goes by all the same.
                self.filter.pass();
                if let Some(warning) = warning {
                    tracing::warn!(subject = human::name(&self.name, Some(number)), "warning: {warning}");
                }
                (record, None)
            }
        };
        let recognised = started.elapsed();
        let content = match (&record, &found) {
            (Record::Answer(answer), Some(found)) => {
                let approach = self.answering.robot.as_ref().zip(answer.strategy.as_ref());
                let approach = approach.map(|(setting, strategy)| setting.approach_in_camera(strategy));
                FrameContent::Hand { found, answer, approach }
            }
            (Record::Failure(failure), _) => FrameContent::Nothing(&failure.error.message),
            (Record::Answer(_), None) => FrameContent::Nothing(""),
        };
        let drawing = self.annotator.draw(number, shown, content);
        let drawn = started.elapsed();
        let bytes = drawing.as_ref().map(output::encoded).transpose()?;
        let done = started.elapsed();
        self.pace.add([decode, recognised - decode, drawn - recognised, done - drawn]);
        Ok((record, bytes))
    }

    /// The frame's pixels, or the record of why there are none.
    fn decoded(&self, frame: Frame) -> Result<Decoded, Record> {
        let number = Some(frame.number);
        let given = frame
            .given
            .map_err(|error| Record::failed(self.name.clone(), number, error.kind(), error.to_string()))?;
        let mut decoded = picture::decode(&given.bytes)
            .map_err(|error| Record::not_recognised(self.name.clone(), number, &error.into()))?;
        decoded.warnings.splice(0..0, given.warning());
        Ok(decoded)
    }
}
