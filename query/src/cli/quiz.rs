//! `grasp-query quiz`.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use grasp_terminal::text::{counted, printable, shown};
use tokio::net::TcpListener;
use tracing::{info, warn};

use super::figures::print;
use super::index_file::IndexFile;
use super::labelled::LabelledArguments;
use super::listen::parse_listen;
use super::outputs::refuse_overwriting;
use super::selection::{Selected, Selection};
use super::signals::signals;
use crate::evaluate::labels::OTHER;
use crate::quiz::answers::AnswerFile;
use crate::quiz::pictures::{self, Shown};
use crate::quiz::server::{Table, serve};
use crate::quiz::{CHOICES, Quiz};
use grasp_program::status::{ERROR, INTERRUPTED, SUCCESS};
use grasp_recognise::Recogniser;
use grasp_recognise::segment::SegmentParams;

/// What the order comes from, unless another seed is named.
pub(super) const DEFAULT_SEED: u64 = 7;

/// Let a person name the grasps of labelled pictures, beside the program: the paper's human
/// baseline.
///
/// Serves a page that shows the hand images as the program sees them (the hand cut out, cropped and
/// grey) in random order, and takes the answers by mouse, touch or the keys 1 to 6; Backspace goes
/// back one picture. Every answer is kept at once: started again with the same --out, the quiz goes
/// on where it stopped. The page shows nothing of the labels until the last picture is answered;
/// then it shows the person's confusion matrix beside the program's. Ctrl-C ends the quiz and
/// prints the table so far.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query quiz tests/pictures/labels.csv             in the browser of this machine
  grasp-query quiz tests/pictures/labels.csv --where kind=segmented --limit 60 --out anna.csv
  grasp-query quiz tests/pictures/labels.csv --listen 0.0.0.0:8080
                                                         for a phone in the same network
  grasp-query quiz tests/pictures/labels.csv --index grasp.idx --hand right --json > result.json

Pictures in none of the six grasps are left out.

Exit status: 0 when every picture was answered, 130 when Ctrl-C came before, 2 where the table or a
picture of it could not be used.")]
pub(super) struct Quizzing {
    #[command(flatten)]
    index: IndexFile,
    /// Where the page is served; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:0", value_parser = parse_listen)]
    listen: SocketAddr,
    /// What the order comes from.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Keep the answers in this table, and go on from what is in it.
    #[arg(long, value_name = "ANSWERS.csv", default_value = "answers.csv")]
    out: PathBuf,
    /// Show at most N pictures.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    limit: Option<u32>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl Quizzing {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        refuse_overwriting(&self.out, [self.labelled.selection.path(), self.index.path().as_path()])?;
        let index = self.index.open_if_there()?;
        let limit = self.limit.map_or(usize::MAX, |limit| limit as usize);
        let recognise = self.labelled.recognise.options()?;
        let segment = recognise.segment.clone();
        let recogniser = index.as_ref().map(|index| Recogniser::new(index, recognise));
        let labelled_masks = self.labelled.labelled_masks;
        let options = QuizOptions { seed: self.seed, limit, labelled_masks, segment, recogniser };
        let (quiz, errors) = make(&self.labelled.selection, &self.out, &options)?;
        let table = Table::new(quiz);
        self.serve(&table)?;

        let quiz = table.quiz();
        print(self.labelled.json, &quiz.result(), || quiz.result().text())?;
        Ok(match (errors, quiz.is_complete()) {
            (1.., _) => ERROR,
            (0, false) => INTERRUPTED,
            (0, true) => SUCCESS,
        })
    }

    /// Serves until Ctrl-C.
    fn serve(&self, table: &Table) -> anyhow::Result<()> {
        // One person answers: one thread is enough.
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(async {
            let (stop, _) = signals(None::<fn()>)?;
            let listener = TcpListener::bind(self.listen)
                .await
                .with_context(|| format!("cannot listen at {}: name another with --listen", self.listen))?;
            let address = listener.local_addr()?;
            let state = table.quiz().state();
            let open = match address.ip().is_unspecified() {
                true => {
                    let port = address.port();
                    format!("http://localhost:{port}/ in a browser here, or by this machine's address on another")
                }
                false => format!("http://{address}/ in a browser"),
            };
            info!(
                "{}, {} answered before, in the order of seed {}; answers go to {}\nopen {open}; Ctrl-C ends the quiz",
                counted(state.total, ["picture", "pictures"]),
                state.answered,
                state.seed,
                shown(&self.out),
            );
            Ok(serve(listener, table.clone(), stop).await?)
        })
    }
}

/// How a quiz is made.
pub(super) struct QuizOptions<'a> {
    /// What the order comes from.
    pub(super) seed: u64,
    /// The most pictures.
    pub(super) limit: usize,
    /// Take the labelled masks of camera pictures.
    pub(super) labelled_masks: bool,
    /// How hands are found in camera pictures.
    pub(super) segment: SegmentParams,
    /// Who is asked the same.
    pub(super) recogniser: Option<Recogniser<'a>>,
}

/// The quiz over the selected pictures, and how many rows and pictures of them could not be used,
/// each reported on standard error.
pub(super) fn make(
    selection: &Selection,
    out: &Path,
    options: &QuizOptions<'_>,
) -> anyhow::Result<(Quiz, usize)> {
    let classes: Vec<String> = CHOICES.iter().map(|choice| choice.grasp.to_owned()).collect();
    let Selected { mut labels, broken, folder } = selection.read(&classes)?;
    labels.retain(|label| label.grasp != OTHER);
    let labels = pictures::shuffled(labels, options.seed, options.limit);
    // Before the pictures: a table that cannot be written should not be found out after the work.
    let (answers, before) = AnswerFile::open(out)?;
    let mut errors = broken.len();
    for row in &broken {
        warn!(line = row.line, "line {}: {}", row.line, printable(&row.fault.to_string()));
    }
    let mut shown: Vec<Shown> = Vec::new();
    for made in pictures::make(
        &labels,
        &folder,
        options.labelled_masks,
        &options.segment,
        options.recogniser.as_ref(),
    ) {
        match made {
            Ok(picture) => shown.push(picture),
            Err((file, miss)) => {
                errors += usize::from(!miss.is_rejection);
                warn!(file, "{} is left out: {}", printable(&file), printable(&miss.message));
            }
        }
    }
    if let Some(recogniser) = &options.recogniser {
        recogniser.index().check_unchanged().context("cannot use the index")?;
    }
    if shown.is_empty() {
        bail!("no picture of {} can be shown", selection.path().display());
    }
    Ok((Quiz::new(shown, answers, &before, options.seed), errors))
}
