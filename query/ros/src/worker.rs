//! Answers pictures: one at a time, the newest.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use grasp_answer::index_file;
use grasp_index::Index;
use grasp_recognise::picture::Decoded;
use grasp_recognise::segment::SegmentParams;
use grasp_recognise::sequence::{Filter, SequenceParams};
use grasp_recognise::{MaskSource, Prepared, RecogniseError, Recogniser, Recognition, Timings};
use grasp_terminal::error::message;
use ros2_client::{Publisher, WriteError};
use serde::Serialize;

use crate::answer::grasp::Robot;
use crate::answer::{Hand, Original, detection, marker};
use crate::arguments::Options;
use crate::latency::Latencies;
use crate::log::{Level, Log};
use crate::messages::geometry::PoseStamped;
use crate::messages::moveit::Grasp;
use crate::messages::sensor::{CameraInfo, CompressedImage, Image};
use crate::messages::standard::Header;
use crate::messages::vision::Detection2DArray;
use crate::messages::visualization::MarkerArray;
use crate::newest::Newest;
use crate::picture::{Unreadable, of_compressed, of_image};
use crate::view::View;

/// A picture as it came.
#[derive(Debug)]
pub(crate) enum Picture {
    Raw(Image),
    Compressed(CompressedImage),
}

impl Picture {
    fn header(&self) -> &Header {
        match self {
            Self::Raw(image) => &image.header,
            Self::Compressed(image) => &image.header,
        }
    }

    fn decoded(&self) -> Result<Decoded, Unreadable> {
        match self {
            Self::Raw(image) => of_image(image),
            Self::Compressed(image) => of_compressed(image),
        }
    }
}

/// A picture, and what was known when it came.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) picture: Picture,
    pub(crate) came: Instant,
    pub(crate) info: Option<Arc<CameraInfo>>,
    pub(crate) object: Option<Arc<PoseStamped>>,
}

/// Where answers go.
pub(crate) struct Answers {
    pub(crate) detections: Publisher<Detection2DArray>,
    pub(crate) pose: Publisher<PoseStamped>,
    pub(crate) markers: Publisher<MarkerArray>,
    pub(crate) grasp: Publisher<Grasp>,
}

/// How many pictures there were.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    /// With a grasp.
    pub(crate) recognised: u64,
    /// With a hand whose grasp is unknown.
    pub(crate) unknown: u64,
    /// Without a hand.
    pub(crate) empty: u64,
    /// That could not be read.
    pub(crate) unreadable: u64,
    /// From a picture's coming to the last of its answers' going.
    pub(crate) latencies: Latencies,
}

/// Answers pictures.
pub(crate) struct Worker<'a> {
    recogniser: Recogniser<'a>,
    index_path: &'a Path,
    source: MaskSource,
    segment: SegmentParams,
    filter: Option<Filter>,
    depth: f64,
    is_rectified: bool,
    robot: Option<Robot>,
    answers: Answers,
    log: &'a Log,
    tally: Tally,
}

impl<'a> Worker<'a> {
    /// One that works as the options say; `is_rectified` of all pictures.
    pub(crate) fn new(
        index_path: &'a Path,
        index: &'a Index,
        options: &Options,
        is_rectified: bool,
        robot: Option<Robot>,
        answers: Answers,
        log: &'a Log,
    ) -> Self {
        let recognition = options.recognition();
        Self {
            segment: recognition.segment.clone(),
            recogniser: Recogniser::new(index, recognition),
            index_path,
            source: if options.segmented { MaskSource::Segmented } else { MaskSource::Camera },
            filter: options.sequence.then(|| Filter::new(SequenceParams::default(), None)),
            depth: options.depth,
            is_rectified,
            robot,
            answers,
            log,
            tally: Tally::default(),
        }
    }

    /// Answers what comes until the place is closed.
    ///
    /// # Errors
    /// Where the index was changed meanwhile: no answer can be believed any more.
    pub(crate) fn run(mut self, jobs: &Newest<Job>) -> anyhow::Result<Tally> {
        while let Some(job) = jobs.take() {
            let hand = self.hand(&job);
            index_file::check(self.index_path, self.recogniser.index())?;
            match &hand {
                Ok(_) => self.tally.recognised += 1,
                Err(Nothing::Unknown) => self.tally.unknown += 1,
                Err(Nothing::Empty) => self.tally.empty += 1,
                Err(Nothing::Unreadable { kind, message }) => {
                    self.tally.unreadable += 1;
                    self.log.warn(kind, message);
                    continue;
                }
            }
            self.publish(&job, hand.ok().as_ref());
            self.tally.latencies.add(job.came.elapsed());
        }
        Ok(self.tally)
    }

    /// The hand in a picture, or why there is none.
    fn hand(&mut self, job: &Job) -> Result<Hand, Nothing> {
        let hand = self.found(job);
        if let (Err(nothing), Some(filter)) = (&hand, &mut self.filter)
            && !matches!(nothing, Nothing::Unknown)
        {
            // Time goes by all the same.
            filter.pass();
        }
        hand
    }

    fn found(&mut self, job: &Job) -> Result<Hand, Nothing> {
        let header = job.picture.header();
        let decoded = job.picture.decoded()?;
        let original = Original::of(&decoded.picture);
        let view = job.info.as_ref().and_then(|info| self.view(info, original));
        let mut found = match self.recognise(decoded) {
            Ok(found) => found,
            Err(error) => {
                self.log.say(Level::Debug, &error.to_string());
                return Err(error.into());
            }
        };
        if let Some(filter) = &mut self.filter {
            self.recogniser.follow(&mut found, filter);
        }
        let depth = job.object.as_ref().and_then(|object| depth_of(object, header));
        let hand = Hand::new(&found, header.clone(), original, view.as_ref(), depth.unwrap_or(self.depth));
        hand.ok_or(Nothing::Unknown)
    }

    fn view(&self, info: &CameraInfo, original: Original) -> Option<View> {
        let view = View::new(info, self.is_rectified, original.size);
        if view.is_none() {
            let line = "the camera is not calibrated: its CameraInfo has no focal length, so that hands are put on its \
                        optical axis";
            self.log.warn("camera_info", line);
        }
        view
    }

    /// As `grasp_recognise` recognises a file.
    fn recognise(&self, decoded: Decoded) -> Result<Recognition, RecogniseError> {
        let Decoded { picture, is_jpeg, warnings } = decoded;
        for warning in &warnings {
            self.log.warn("odd", &format!("a picture is odd: {warning}"));
        }
        let prepared = Prepared::new(picture, is_jpeg, &self.source, &self.segment)?;
        self.recogniser.recognise_prepared(prepared, Timings::default())
    }

    fn publish(&self, job: &Job, hand: Option<&Hand>) {
        let header = job.picture.header();
        self.send(&self.answers.detections, detection::message(header, hand));
        if let Some(hand) = hand {
            self.send(&self.answers.pose, hand.pose_stamped());
        }
        self.send(&self.answers.markers, marker::message(header, hand));
        if let (Some(robot), Some(hand)) = (&self.robot, hand) {
            match robot.grasp(hand, job.object.as_deref()) {
                Ok(grasp) => self.send(&self.answers.grasp, grasp),
                Err(error) => self.log.warn(&error.kind(), &error.to_string()),
            }
        }
    }

    fn send<M: Serialize>(&self, publisher: &Publisher<M>, message: M) {
        match publisher.publish(message) {
            Ok(()) => {}
            Err(WriteError::WouldBlock { .. }) => {
                self.log.warn("slow", "an answer was not sent: whoever reads it reliably is too slow");
            }
            Err(error) => {
                self.log.warn("unsent", &format!("an answer was not sent: {}", error.forget_data()));
            }
        }
    }
}

/// Why a picture has no grasp.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Nothing {
    /// There is a hand, but its grasp is unknown.
    Unknown,
    /// There is no hand.
    Empty,
    /// It cannot be read.
    Unreadable {
        /// A short, stable name.
        kind: &'static str,
        /// Why, and what to do.
        message: String,
    },
}

impl From<Unreadable> for Nothing {
    fn from(error: Unreadable) -> Self {
        Self::Unreadable { kind: error.kind(), message: error.to_string() }
    }
}

impl From<RecogniseError> for Nothing {
    fn from(error: RecogniseError) -> Self {
        if error.is_rejection() {
            return Self::Empty;
        }
        let causes = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
        Self::Unreadable { kind: error.kind(), message: message(causes) }
    }
}

/// How far in front of the camera the object is, in metres, where its pose is in the picture's
/// frame: the hand that holds it is about as far.
fn depth_of(object: &PoseStamped, picture: &Header) -> Option<f64> {
    let is_seen = object.header.frame_id == picture.frame_id;
    Some(object.pose.position.z).filter(|depth| is_seen && *depth > 0.0 && depth.is_finite())
}
