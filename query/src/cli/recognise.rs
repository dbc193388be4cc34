//! `grasp-query recognise`.

mod remote;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, bail};
use grasp_index::Index;
use grasp_terminal::error::message;
use grasp_terminal::text::printable;
use rayon::prelude::*;

use super::index_file::IndexFile;
use super::options::{FrameArguments, RecogniseArguments};
use super::robot::RobotArguments;
use crate::client::Address;
use crate::explain;
use crate::output::human;
use crate::output::record::{Record, SingleRecord};
use crate::picture::{self, Frames};
use crate::prior::Priors;
use crate::recognise::{MaskSource, RecogniseError, Recogniser, Recognition};
use crate::robot::{Setting, moveit};
use crate::segment::Mask;
use crate::segment::depth::DepthRange;
use crate::sequence::Filter;

const EXAMPLES: &str = "\
Examples:
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg
  grasp-query recognise --json --timings tests/pictures/camera/*.jpg
  grasp-query recognise --segmented tests/pictures/segmented/09-pinch.png --hand right
  grasp-query recognise tests/pictures/segmented/09-pinch.png --mask tests/pictures/mask/09-pinch.png
  grasp-query recognise PICTURE.png --depth DEPTH.png --depth-range 400..900
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --explain why.png
  grasp-query recognise tests/pictures/camera/*.jpg --sequence --json
                                                         each frame answered by all frames so far
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --prior tests/pictures/prior.toml --holding bottle
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --recall 0.99
                                                         search harder for the true neighbours
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --robot barrett \\
    --object query/data/objects/bottle.toml --camera query/data/objects/camera.toml --arm kuka-kr6-r700
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --server http://127.0.0.1:8750
  ffmpeg -f v4l2 -i /dev/video0 -f image2pipe -c:v mjpeg - | grasp-query recognise --json -";

/// Recognise the grasp in pictures (PNG, JPEG, PNM).
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Recognise {
    /// The pictures; a folder stands for the pictures in it, in the order of their names; `-` reads a picture, or a stream of PNM,
    /// JPEG or PNG frames, from standard input.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    index: IndexFile,
    /// The pictures are segmented already: a hand on black.
    #[arg(long, conflicts_with_all = ["mask", "depth"])]
    segmented: bool,
    /// A mask of the hand, white on black, of the picture's size. For a single picture.
    #[arg(long, value_name = "FILE", conflicts_with = "depth")]
    mask: Option<PathBuf>,
    /// A depth picture (one channel of 16 bits) of the picture's size. For a single picture.
    #[arg(long, value_name = "FILE", requires = "depth_range")]
    depth: Option<PathBuf>,
    /// The depths that are hand, in the depth picture's unit.
    #[arg(long, value_name = "NEAR..FAR", requires = "depth")]
    depth_range: Option<DepthRange>,
    /// Draw how each answer came about: into this PNG file, or, where the name has no `.png`, into files in this folder.
    #[arg(long, value_name = "OUT")]
    explain: Option<PathBuf>,
    /// The pictures are frames of one hand in their order: each is answered by all frames so far.
    #[arg(long)]
    sequence: bool,
    #[command(flatten)]
    frames: FrameArguments,
    /// How objects are usually grasped: a table of [objects.NAME] with grasp = probability. Grasps that it does not name share the rest.
    #[arg(long, value_name = "PRIOR.toml", requires = "holding")]
    prior: Option<PathBuf>,
    /// The object that the hand holds, as the --prior names it.
    #[arg(long, value_name = "NAME", requires = "prior")]
    holding: Option<String>,
    /// Print JSON Lines, one record a picture.
    #[arg(long)]
    json: bool,
    /// Say how long each step took.
    #[arg(long)]
    timings: bool,
    /// Let a running `grasp-query serve` answer, by its own index; http://HOST:PORT or unix:PATH.
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["sequence", "prior"])]
    server: Option<Address>,
    /// Show the service the token in this file.
    #[arg(long, value_name = "FILE", requires = "server")]
    token_file: Option<PathBuf>,
    #[command(flatten)]
    robot: RobotArguments,
    #[command(flatten)]
    recognise: RecogniseArguments,
    /// Some drawing could not be written.
    #[arg(skip)]
    undrawn: AtomicBool,
}

/// What every picture is answered with.
struct Means<'a> {
    recogniser: Recogniser<'a>,
    source: MaskSource,
    robot: Option<Setting>,
    /// The probability of each class without the picture.
    prior: Option<Vec<f64>>,
}

/// The name of standard input, among the pictures and in records.
const STANDARD_INPUT: &str = "-";

/// A picture and what was found in it.
type Found = Result<Recognition, Record>;

impl Recognise {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        let images = self.pictures()?;
        let to_file = self.explain.as_deref().is_some_and(is_png);
        if images.len() > 1 {
            if self.mask.is_some() || self.depth.is_some() {
                bail!("--mask and --depth are for a single picture, but {} are given", images.len());
            }
            if to_file {
                bail!("--explain OUT.png is for a single picture; name a folder instead of a .png file");
            }
        }
        if let Some(folder) = self.explain.as_deref().filter(|_| !to_file) {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        if let Some(out) = self.explain.as_deref().filter(|_| to_file) {
            let pictures = images.iter().chain(&self.mask).chain(&self.depth).map(PathBuf::as_path);
            super::refuse_overwriting(out, pictures.chain([self.index.path().as_path()]))?;
        }
        if let Some(address) = &self.server {
            return self.run_remote(address, &images);
        }
        let robot = self.robot.read()?;
        let index = self.index.open_for_pictures()?;
        let recogniser = Recogniser::new(&index, self.recognise.options());
        let means = Means { recogniser, source: self.source()?, robot, prior: self.prior(&index)? };
        let mut filter = self.sequence.then(|| self.filter(means.prior.clone()));

        let mut output = Output { form: self.form(), status: super::SUCCESS, out: io::stdout().lock() };
        // As many at a time as are answered soon: their pictures are all in memory at once.
        let at_once = 4 * rayon::current_num_threads();
        for group in groups(&images) {
            if group == [Path::new(STANDARD_INPUT)] {
                self.run_stream(&means, &mut filter, &mut output)?;
                continue;
            }
            for batch in group.chunks(at_once) {
                if let Some(filter) = &mut filter {
                    let found: Vec<Found> =
                        batch.par_iter().map(|path| self.find_in_file(&means, path)).collect();
                    for (path, found) in batch.iter().zip(found) {
                        let name = path.display().to_string();
                        output.write(&self.finish(&means, name, None, found, Some(filter)))?;
                    }
                    continue;
                }
                let answer = |path: &PathBuf| {
                    self.finish(
                        &means,
                        path.display().to_string(),
                        None,
                        self.find_in_file(&means, path),
                        None,
                    )
                };
                // A single picture is answered before a pool of threads would have started.
                let records: Vec<Record> = match batch {
                    [single] => vec![answer(single)],
                    several => several.par_iter().map(answer).collect(),
                };
                for record in &records {
                    output.write(record)?;
                }
            }
        }
        Ok(self.status_of(&output))
    }

    fn form(&self) -> Form {
        match (self.json, self.robot.is_moveit()) {
            (true, _) => Form::Json,
            (false, true) => Form::Moveit,
            (false, false) => Form::Text,
        }
    }

    /// What is to be recognised, with the pictures of a folder in its place.
    fn pictures(&self) -> anyhow::Result<Vec<PathBuf>> {
        let mut pictures = Vec::with_capacity(self.images.len());
        for path in &self.images {
            if !path.is_dir() {
                pictures.push(path.clone());
                continue;
            }
            let found = picture::pictures_in(path)
                .with_context(|| format!("cannot read the folder {}", path.display()))?;
            if found.is_empty() {
                bail!(
                    "the folder {} holds no picture: name pictures, or a folder that holds some",
                    path.display()
                );
            }
            pictures.extend(found);
        }
        Ok(pictures)
    }

    fn status_of<W>(&self, output: &Output<W>) -> u8 {
        if self.undrawn.load(Ordering::Relaxed) { super::ERROR } else { output.status }
    }

    fn run_stream(
        &self,
        means: &Means<'_>,
        filter: &mut Option<Filter>,
        output: &mut Output<impl Write>,
    ) -> anyhow::Result<()> {
        each_frame(|frame, bytes| {
            let name = || STANDARD_INPUT.to_owned();
            let found = bytes.and_then(|bytes| self.find(means, name(), frame, &bytes));
            output.write(&self.finish(means, name(), frame, found, filter.as_mut()))
        })
    }

    fn find_in_file(&self, means: &Means<'_>, path: &Path) -> Found {
        let name = path.display().to_string();
        match picture::read(path) {
            Ok(bytes) => self.find(means, name, None, &bytes),
            Err(error) => Err(Record::not_recognised(name, None, &error.into())),
        }
    }

    fn find(&self, means: &Means<'_>, name: String, frame: Option<u64>, bytes: &[u8]) -> Found {
        let found = means.recogniser.recognise(bytes, &means.source);
        found.map_err(|error| Record::not_recognised(name, frame, &error))
    }

    /// The record of what was found, after the frames before it where there is a filter.
    fn finish(
        &self,
        means: &Means<'_>,
        name: String,
        frame: Option<u64>,
        found: Found,
        filter: Option<&mut Filter>,
    ) -> Record {
        let index = means.recogniser.index();
        let mut found = match (found, &filter) {
            (Ok(found), _) => found,
            (Err(record), None) => return record,
            (Err(record), Some(_)) => {
                // Time goes by all the same.
                filter.map(Filter::skip);
                return record;
            }
        };
        let mut single = None;
        match (filter, &means.prior) {
            (Some(filter), _) => {
                single = Some(SingleRecord::new(&found));
                means.recogniser.follow(&mut found, filter);
            }
            (None, Some(prior)) => means.recogniser.weigh(&mut found, prior),
            (None, None) => {}
        }
        let mut record = match Record::answer(name.clone(), frame, &found, index, self.timings) {
            Ok(record) => record,
            Err(error) => return Record::failed(name, frame, "index", error.to_string()),
        };
        if let Record::Answer(answer) = &mut record {
            answer.single = single;
            if let Some(setting) = &means.robot {
                setting.complete(answer, &found);
            }
        }
        self.drawn(&name, self.draw(&record, &found, index));
        record
    }

    /// Reports a drawing that could not be written; the answer stands, drawn or not.
    fn drawn(&self, name: &str, outcome: anyhow::Result<()>) {
        if let Err(error) = outcome {
            self.undrawn.store(true, Ordering::Relaxed);
            let _ = writeln!(io::stderr(), "{}: {}", printable(name), message(error.chain()));
        }
    }

    fn draw(
        &self,
        record: &Record,
        found: &crate::recognise::Recognition,
        index: &Index,
    ) -> anyhow::Result<()> {
        let (Some(out), Record::Answer(answer)) = (&self.explain, record) else {
            return Ok(());
        };
        let path = if is_png(out) { out.clone() } else { out.join(drawing_name(&answer.file, answer.frame)) };
        explain::save(&explain::draw(found, answer, index), &path)
            .with_context(|| format!("cannot write {}", path.display()))
    }

    fn filter(&self, prior: Option<Vec<f64>>) -> Filter {
        Filter::new(self.frames.params(), prior)
    }

    fn prior(&self, index: &Index) -> anyhow::Result<Option<Vec<f64>>> {
        let (Some(path), Some(object)) = (&self.prior, &self.holding) else { return Ok(None) };
        let grasps: Vec<String> = index.catalogue().classes.iter().map(|class| class.name.clone()).collect();
        Ok(Some(Priors::read(path)?.of(object, &grasps)?))
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
        Ok(MaskSource::Skin)
    }
}

/// The pictures in their order, standard input by itself.
fn groups(images: &[PathBuf]) -> impl Iterator<Item = &[PathBuf]> {
    let stdin = Path::new(STANDARD_INPUT);
    images.chunk_by(move |a, b| a != stdin && b != stdin)
}

/// Standard input, frame by frame: each is answered before the next is awaited. `answer` is given a frame's number, where there are
/// several, and its bytes, or the record of why there are none.
fn each_frame(
    mut answer: impl FnMut(Option<u64>, Result<Vec<u8>, Record>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut frames = Frames::new(io::stdin().lock());
    let name = || STANDARD_INPUT.to_owned();
    let Some(first) = frames.next() else {
        let empty = RecogniseError::Decode(picture::DecodeError::Empty);
        return answer(None, Err(Record::not_recognised(name(), None, &empty)));
    };
    // A picture alone has no frame number: only what follows tells a stream from it.
    let mut held = Some(first);
    let mut number = 0;
    while let Some(frame) = held.take() {
        let is_stream = number > 0 || frames.has_more();
        let frame_number = is_stream.then_some(number);
        let bytes = frame.map_err(|error| Record::failed(name(), frame_number, "stream", error.to_string()));
        answer(frame_number, bytes)?;
        held = frames.next();
        number += 1;
    }
    Ok(())
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// The file name of a drawing in a folder: the picture's path with its separators flattened, so that `a/1.jpg` and
/// `b/1.jpg` do not overwrite each other where only the last part would be the same.
fn drawing_name(file: &str, frame: Option<u64>) -> String {
    let flat = file.trim_start_matches(['.', '/', '\\']).replace(['/', '\\', ':'], "_");
    match frame {
        Some(frame) => format!("frame-{frame:06}.png"),
        None if flat == "-" || flat.is_empty() => "stdin.png".into(),
        None => format!("{flat}.png"),
    }
}

/// What a record is written as.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Text,
    Json,
    Moveit,
}

/// Writes records in order and remembers the worst exit status.
struct Output<W> {
    form: Form,
    status: u8,
    out: W,
}

impl<W: Write> Output<W> {
    fn write(&mut self, record: &Record) -> anyhow::Result<()> {
        self.status = self.status.max(record.status());
        match (self.form, record) {
            (Form::Json, _) => {
                serde_json::to_writer(&mut self.out, record).map_err(io::Error::from)?;
                self.out.write_all(b"\n")?;
            }
            (Form::Moveit, Record::Answer(answer)) if answer.strategy.is_some() => {
                self.out.write_all(moveit::of_answer(answer).unwrap_or_default().as_bytes())?;
            }
            (Form::Text, Record::Answer(_)) => self.out.write_all(human::text(record).as_bytes())?,
            // Standard output is answers; why there is none belongs beside it.
            (Form::Text | Form::Moveit, _) => {
                let _ = io::stderr().write_all(human::text(record).as_bytes());
            }
        }
        self.out.flush()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_of_files_of_the_same_name_differ() {
        assert_eq!(drawing_name("a/1.jpg", None), "a_1.jpg.png");
        assert_ne!(drawing_name("a/1.jpg", None), drawing_name("b/1.jpg", None));
        assert_eq!(drawing_name("-", Some(12)), "frame-000012.png");
        assert_eq!(drawing_name("-", None), "stdin.png");
    }
}
