//! `grasp-query recognise`.

mod drawings;
mod feed;
mod landmarks;
mod output;
#[cfg(feature = "serve")]
mod remote;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, bail};
use grasp_index::Index;
use grasp_terminal::error::message;
use rayon::prelude::*;

use super::answering::Answering;
use super::index_file::IndexFile;
use super::options::{FrameArguments, RecogniseArguments};
use super::outputs::refuse_overwriting_by_any;
use super::pictures::pictures;
use super::robot::{MessageArguments, RobotArguments};
use drawings::Drawings;
use feed::{Feed, is_stream};
use grasp_answer::explain;
use grasp_answer::human;
use grasp_answer::record::Record;
use grasp_program::status::{ERROR, SUCCESS};
use grasp_recognise::picture;
use grasp_recognise::prior::Priors;
use grasp_recognise::segment::depth::DepthRange;
use grasp_recognise::segment::{Finder, Mask, SegmentParams};
use grasp_recognise::sequence::Filter;
use grasp_recognise::{MaskSource, Recogniser, Recognition, Warning};
#[cfg(feature = "serve")]
use grasp_serve::client::Address;
use output::{Output, OutputFormat};

const EXAMPLES: &str = "\
Examples:
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg
  grasp-query recognise --json --timings tests/pictures/camera/*.jpg
  grasp-query recognise --segmented tests/pictures/segmented/09-pinch.png --hand right
  grasp-query recognise tests/pictures/segmented/09-pinch.png \\
    --mask tests/pictures/mask/09-pinch.png
  grasp-query recognise tests/pictures/camera/09-pinch.jpg \\
    --landmarks-json tests/pictures/landmarks/09-pinch.json
  grasp-query recognise PICTURE.png --depth DEPTH.png --depth-range 400..900
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --explain why.png
  grasp-query recognise tests/pictures/camera/*.jpg --sequence --json
                                                         each frame answered by all frames so far
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg \\
    --prior tests/pictures/prior.toml --holding bottle
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --recall 0.99
                                                         search harder for the true neighbours
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --robot barrett \\
    --object query/data/objects/bottle.toml --camera query/data/objects/camera.toml \\
    --arm kuka-kr6-r700
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --server http://127.0.0.1:8750
  grasp-query recognise --camera 0 --sequence --json     the frames of a camera, as they come
  ffmpeg -i VIDEO.mp4 -f mjpeg - | grasp-query recognise --json -

Exit status: 0 all recognised, 1 some picture was rejected or unknown or a strategy is not feasible,
2 an error.";

/// Recognise the grasp in pictures (PNG, JPEG, WebP, GIF, BMP, PNM).
#[derive(Debug, clap::Args)]
#[command(
    after_help = EXAMPLES,
    mut_arg("switch", |switch| switch.requires("sequence")),
    mut_arg("motion", |motion| motion.requires("sequence")),
)]
pub(super) struct Recognise {
    /// The pictures; a folder stands for the pictures in it, in the order of their names; `-` reads
    /// a picture or a stream from standard input: PNM, JPEG or PNG frames, HTTP multipart MJPEG or
    /// YUV4MPEG2. So is a file read whose name ends in .mjpg, .mjpeg or .y4m.
    #[arg(required_unless_present = "cameras", value_name = "IMAGE")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    index: IndexFile,
    /// The pictures are segmented already: a hand on black.
    #[arg(long, conflicts_with_all = ["mask", "depth", "landmarks_json"])]
    segmented: bool,
    /// A mask of the hand, white on black, of the picture's size. For a single picture.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["depth", "landmarks_json"])]
    mask: Option<PathBuf>,
    /// A depth picture (one channel of 16 bits) of the picture's size. For a single picture.
    #[arg(long, value_name = "FILE", requires = "depth_range")]
    depth: Option<PathBuf>,
    /// The depths that are hand, in the depth picture's unit.
    #[arg(long, value_name = "NEAR..FAR", requires = "depth")]
    depth_range: Option<DepthRange>,
    /// Where the hand's 21 joints are, as a tracker has found them: {"unit": "pixel" or "share",
    /// "landmarks": [[x, y], ...]} in MediaPipe's order. For a single picture.
    #[arg(long, value_name = "FILE", conflicts_with = "depth")]
    landmarks_json: Option<PathBuf>,
    /// Print JSON Lines, one record per picture.
    #[arg(long)]
    json: bool,
    /// Draw how each answer came about: into the file OUT.png or OUT.jpg, or into files in a
    /// folder.
    ///
    /// OUT is a folder where it ends in a slash, where it is a folder already, and where several
    /// pictures are given; its files are PNGs named after the pictures, or after the frames of a
    /// stream.
    #[arg(long, value_name = "OUT")]
    explain: Option<PathBuf>,
    /// Say how long each step took.
    #[arg(long)]
    timings: bool,
    /// The pictures are frames of one hand in their order: each is answered by all frames so far.
    #[arg(long)]
    sequence: bool,
    /// How objects are usually grasped: a table of [objects.NAME] with grasp = probability. Grasps
    /// that it does not name share the rest.
    #[arg(long, value_name = "PRIOR.toml", requires = "holding")]
    prior: Option<PathBuf>,
    /// The object that the hand holds, as the --prior names it.
    #[arg(long, value_name = "NAME", requires = "prior")]
    holding: Option<String>,
    #[cfg(feature = "serve")]
    /// Let a running `grasp-query serve` answer, by its own index; http://HOST:PORT or unix:PATH.
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["sequence", "switch", "motion", "prior", "holding"])]
    server: Option<Address>,
    #[cfg(feature = "serve")]
    /// Show the service the token in this file.
    #[arg(long, value_name = "FILE", requires = "server")]
    token_file: Option<PathBuf>,
    #[command(flatten)]
    robot: RobotArguments,
    #[command(flatten)]
    message: MessageArguments,
    #[command(flatten)]
    recognise: RecogniseArguments,
    #[command(flatten)]
    frames: FrameArguments,
    /// Some drawing could not be written.
    #[arg(skip)]
    undrawn: AtomicBool,
}

/// What every picture is answered with.
struct Setup<'a> {
    answering: Answering<'a>,
    source: MaskSource,
    /// The probability of each class without the picture.
    prior: Option<Vec<f64>>,
    drawings: Option<Drawings>,
}

/// A picture and what was found in it.
type Found = Result<Recognition, Record>;

impl Recognise {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        let images = pictures(&self.images)?;
        let camera = self.robot.device()?;
        self.check_inputs(&images, camera)?;
        let drawings = self.drawings(&images)?;
        #[cfg(feature = "serve")]
        if let Some(address) = &self.server {
            return self.run_remote(address, &images, drawings.as_ref());
        }
        let robot = self.robot.read()?;
        let are_cut_out = self.segmented || self.mask.is_some() || self.depth.is_some();
        let options = self.recognise.options()?;
        read_ahead(&options.segment, are_cut_out);
        let index = self.index.open_for_pictures()?;
        let recogniser = Recogniser::new(&index, options);
        let answering = Answering { recogniser, robot, timings: self.timings };
        let setup = Setup { answering, source: self.source()?, prior: self.prior(&index)?, drawings };
        let mut filter = self.sequence.then(|| self.filter(setup.prior.clone()));

        let mut output = Output { format: self.format(), status: SUCCESS, out: io::stdout().lock() };
        if let Some(camera) = camera {
            self.run_feed(Feed::camera(camera)?, &setup, &mut filter, &mut output)?;
        }
        self.run_files(&images, &setup, &mut filter, &mut output)?;
        Ok(self.status_of(&output))
    }

    /// Whether there is something to recognise, of one kind.
    fn check_inputs(&self, images: &[PathBuf], camera: Option<&Path>) -> anyhow::Result<()> {
        match (camera, images) {
            (Some(camera), [_, ..]) => {
                bail!("the frames are those of the camera {}: leave out the pictures", camera.display())
            }
            (None, []) => bail!("name pictures, or a camera by its number, as in --camera 0"),
            _ => {}
        }
        if self.is_of_one() && (images.len() > 1 || camera.is_some()) {
            let given =
                if camera.is_some() { "a camera's are".into() } else { format!("{} are", images.len()) };
            bail!("--mask, --depth and --landmarks-json are for a single picture, but {given} given");
        }
        Ok(())
    }

    /// Answers pictures and streams, in their order.
    fn run_files<W: Write>(
        &self,
        images: &[PathBuf],
        setup: &Setup<'_>,
        filter: &mut Option<Filter>,
        output: &mut Output<W>,
    ) -> anyhow::Result<()> {
        // As many at a time as are answered soon: their pictures are all in memory at once. A
        // single picture is answered before a pool of threads would have started, and to ask how
        // many there are starts it.
        let at_once = if images.len() > 1 { 4 * rayon::current_num_threads() } else { 1 };
        for group in groups(images) {
            if let [only] = group
                && is_stream(only)
            {
                self.run_feed(Feed::Stream(only.clone()), setup, filter, output)?;
                continue;
            }
            for batch in group.chunks(at_once) {
                match filter {
                    Some(filter) => self.run_sequence(batch, setup, filter, output)?,
                    None => self.run_batch(batch, setup, output)?,
                }
            }
        }
        Ok(())
    }

    /// Answers pictures as frames of one sequence: found side by side, decided one after another.
    fn run_sequence<W: Write>(
        &self,
        batch: &[PathBuf],
        setup: &Setup<'_>,
        filter: &mut Filter,
        output: &mut Output<W>,
    ) -> anyhow::Result<()> {
        let found: Vec<Found> = batch.par_iter().map(|path| self.find_in_file(setup, path)).collect();
        for (path, found) in batch.iter().zip(found) {
            let record = self.finish(setup, path.display().to_string(), None, found, Some(filter));
            self.index.check(setup.answering.recogniser.index())?;
            output.write(&record)?;
        }
        Ok(())
    }

    /// Answers pictures, each by itself.
    fn run_batch<W: Write>(
        &self,
        batch: &[PathBuf],
        setup: &Setup<'_>,
        output: &mut Output<W>,
    ) -> anyhow::Result<()> {
        let answer = |path: &PathBuf| {
            let found = self.find_in_file(setup, path);
            self.finish(setup, path.display().to_string(), None, found, None)
        };
        let records: Vec<Record> = match batch {
            [single] => vec![answer(single)],
            several => several.par_iter().map(answer).collect(),
        };
        self.index.check(setup.answering.recogniser.index())?;
        records.iter().try_for_each(|record| output.write(record))
    }

    /// Where drawings go, where any are asked for. No input is drawn over.
    fn drawings(&self, images: &[PathBuf]) -> anyhow::Result<Option<Drawings>> {
        let Some(out) = &self.explain else { return Ok(None) };
        let drawings = Drawings::new(out, images.len())?;
        let inputs = images.iter().chain(&self.mask).chain(&self.depth).chain(&self.landmarks_json);
        refuse_overwriting_by_any(
            drawings.files(images)?.iter().map(PathBuf::as_path),
            inputs.map(PathBuf::as_path).chain([self.index.path().as_path()]),
        )?;
        drawings.prepare()?;
        Ok(Some(drawings))
    }

    fn format(&self) -> OutputFormat {
        match (self.json, self.message.is_moveit()) {
            (true, _) => OutputFormat::Json,
            (false, true) => OutputFormat::Moveit,
            (false, false) => OutputFormat::Text,
        }
    }

    fn status_of<W>(&self, output: &Output<W>) -> u8 {
        if self.undrawn.load(Ordering::Relaxed) { ERROR } else { output.status }
    }

    fn run_feed(
        &self,
        feed: Feed,
        setup: &Setup<'_>,
        filter: &mut Option<Filter>,
        output: &mut Output<impl Write>,
    ) -> anyhow::Result<()> {
        let name = feed.name();
        feed.each_frame(|frame, given| {
            self.refuse_more(&name, frame)?;
            let found = given.and_then(|given| {
                let mut found = self.find(setup, name.clone(), frame, &given.bytes);
                match (&mut found, given.warning()) {
                    (Ok(found), Some(warning)) => {
                        found.warnings.insert(0, Warning::Decoding(warning.to_string()));
                    }
                    (Err(_), Some(warning)) => {
                        tracing::warn!(subject = human::name(&name, frame), "warning: {warning}");
                    }
                    (_, None) => {}
                }
                found
            });
            let record = self.finish(setup, name.clone(), frame, found, filter.as_mut());
            self.index.check(setup.answering.recogniser.index())?;
            output.write(&record)
        })
    }

    /// A mask, a depth picture and landmarks are of one picture: a stream of several is refused
    /// when its second comes.
    fn refuse_more(&self, name: &str, frame: Option<u64>) -> anyhow::Result<()> {
        if self.is_of_one() && frame.is_some_and(|frame| frame > 0) {
            bail!("--mask, --depth and --landmarks-json are for a single picture, but {name} has more");
        }
        Ok(())
    }

    /// Whether something is given that belongs to a single picture.
    fn is_of_one(&self) -> bool {
        self.mask.is_some() || self.depth.is_some() || self.landmarks_json.is_some()
    }

    fn find_in_file(&self, setup: &Setup<'_>, path: &Path) -> Found {
        let name = path.display().to_string();
        match picture::read(path) {
            Ok(bytes) => self.find(setup, name, None, &bytes),
            Err(error) => Err(Record::not_recognised(name, None, &error.into())),
        }
    }

    fn find(&self, setup: &Setup<'_>, name: String, frame: Option<u64>, bytes: &[u8]) -> Found {
        let found = setup.answering.recogniser.recognise(bytes, &setup.source);
        found.map_err(|error| Record::not_recognised(name, frame, &error))
    }

    /// The record of what was found, after the frames before it where there is a filter.
    fn finish(
        &self,
        setup: &Setup<'_>,
        name: String,
        frame: Option<u64>,
        found: Found,
        filter: Option<&mut Filter>,
    ) -> Record {
        let answering = &setup.answering;
        let mut found = match found {
            Ok(found) => found,
            Err(record) => {
                // Time goes by all the same.
                filter.map(Filter::pass);
                return record;
            }
        };
        // A filter has the prior from its first frame on.
        if let (None, Some(prior)) = (&filter, &setup.prior) {
            answering.recogniser.weigh(&mut found, prior);
        }
        let record = answering.record(&name, frame, &mut found, filter);
        let index = answering.recogniser.index();
        if let (Some(drawings), Record::Answer(answer)) = (&setup.drawings, &record) {
            let drawing = explain::draw(&found, answer, index);
            // What an index says that has changed is no answer: its record will not be written
            // either.
            if index.check_unchanged().is_ok() {
                self.drawn(&name, frame, drawings.path(&name, frame), |path| {
                    Ok(explain::save(&drawing, path)?)
                });
            }
        }
        record
    }

    /// Draws into the file that a picture's drawing belongs in. Reports a drawing that could not be
    /// made; the answer stands, drawn or not.
    fn drawn(
        &self,
        name: &str,
        frame: Option<u64>,
        path: anyhow::Result<PathBuf>,
        draw: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) {
        let outcome =
            path.and_then(|path| draw(&path).with_context(|| format!("cannot write {}", path.display())));
        if let Err(error) = outcome {
            // Of a stream's many frames, the first one's failure says enough.
            if !self.undrawn.swap(true, Ordering::Relaxed) || frame.is_none() {
                tracing::error!(subject = name, "{}", message(error.chain()));
            }
        }
    }

    fn filter(&self, prior: Option<Vec<f64>>) -> Filter {
        Filter::new(self.frames.params(), prior)
    }

    fn prior(&self, index: &Index) -> anyhow::Result<Option<Vec<f64>>> {
        let (Some(path), Some(object)) = (&self.prior, &self.holding) else { return Ok(None) };
        Ok(Some(Priors::read(path)?.probabilities(object, &index.catalogue().class_names())?))
    }

    fn source(&self) -> anyhow::Result<MaskSource> {
        if self.segmented {
            return Ok(MaskSource::Segmented);
        }
        if let Some(path) = &self.mask {
            let decoded = picture::read(path).and_then(|bytes| picture::decode_grey(&bytes));
            let (width, height, grey) =
                decoded.with_context(|| format!("cannot use the mask {}", path.display()))?;
            return Ok(MaskSource::Given(Mask::from_grey(width, height, &grey)));
        }
        if let (Some(path), Some(range)) = (&self.depth, self.depth_range) {
            let decoded = picture::read(path).and_then(|bytes| picture::decode_grey16(&bytes));
            let (width, height, depth) =
                decoded.with_context(|| format!("cannot use the depth picture {}", path.display()))?;
            return Ok(MaskSource::Depth { width, height, depth, range });
        }
        if let Some(path) = &self.landmarks_json {
            return Ok(MaskSource::Landmarks(landmarks::read(path)?));
        }
        Ok(MaskSource::Camera)
    }
}

/// Begins to read the networks that will be asked, on another thread, while this one opens the
/// index.
fn read_ahead(segment: &SegmentParams, are_cut_out: bool) {
    if segment.by != Finder::Skin && rayon::current_num_threads() > 1 {
        let networks = segment.networks.clone();
        rayon::spawn(move || networks.read_ahead(are_cut_out));
    }
}

/// The pictures in their order, each stream by itself.
fn groups(images: &[PathBuf]) -> impl Iterator<Item = &[PathBuf]> {
    images.chunk_by(|a, b| !is_stream(a) && !is_stream(b))
}
