//! `grasp-query serve`.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Context as _, bail};
use grasp_terminal::text::{counted, printable};
use tokio::net::TcpListener;
use tracing::{info, warn};

use super::index_file::IndexFile;
use super::listen::parse_listen;
use super::outputs::refuse_overwriting;
use super::quiz::{DEFAULT_SEED, QuizOptions, make};
use super::selection::Selection;
use super::signals::signals;
use crate::quiz::server::{Table, router};
use grasp_program::Global;
use grasp_program::status::{ERROR, INTERRUPTED, SUCCESS};
use grasp_recognise::segment::SegmentParams;
use grasp_recognise::{RecogniseOptions, Recogniser};
use grasp_serve::{Ended, Event, Listener, Service, Settings};

/// Where the service listens unless told otherwise.
const DEFAULT_ADDRESS: &str = "127.0.0.1:8750";

/// Answer over HTTP for as long as it runs: robots, scripts, and people by the page at /.
///
/// The index is opened once. Where another file is put in its place (by `grasp-builder build --out`
/// or by renaming), that one is checked and takes over between two requests; one that cannot be
/// used is reported, and the old one goes on. A file copied over the one that is served takes over
/// when it is whole. SIGHUP opens it anew at once. SIGTERM and Ctrl-C let the requests under way
/// finish.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query serve --index grasp.idx                    the page: http://127.0.0.1:8750/
  grasp-query serve --unix /run/grasp/grasp.sock         for programs of this machine
  grasp-query serve --listen 0.0.0.0:8750 --token-file TOKEN.txt
  curl --data-binary @tests/pictures/camera/01-large-diameter.jpg http://127.0.0.1:8750/v1/recognise
  grasp-query recognise --server http://127.0.0.1:8750 --json tests/pictures/camera

/openapi.json describes every path.

Exit status: 0 after SIGTERM, 130 after Ctrl-C, 2 where something failed or requests were cut short.")]
pub(super) struct Serve {
    #[command(flatten)]
    index: IndexFile,
    /// Where to listen; port 0 takes a free one [default: 127.0.0.1:8750, unless --unix is given].
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = parse_listen)]
    listen: Option<SocketAddr>,
    /// Listen at this path, for programs of the same user.
    #[cfg(unix)]
    #[arg(long, value_name = "PATH")]
    unix: Option<PathBuf>,
    /// Ask for the token in this file; needed to listen beyond this machine.
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Requests that may wait while all threads work; more are rejected with status 429, to be
    /// tried again later.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(0..=4096))]
    queue: u16,
    /// The largest request, in megabytes.
    #[arg(long, value_name = "MB", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=1024))]
    max_body: u16,
    /// The largest picture, in megapixels; its header is read before it is decoded.
    #[arg(long, value_name = "MP", default_value_t = 25, value_parser = clap::value_parser!(u16).range(1..=128))]
    max_pixels: u16,
    /// Seconds that a request may take to arrive, and again to be answered. A body that brings
    /// neither 4 KiB nor its end in five seconds is not waited for.
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0, value_parser = parse_seconds, allow_negative_numbers = true)]
    timeout: f64,
    /// Seconds between two looks at whether another index lies at the path.
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = parse_seconds, allow_negative_numbers = true)]
    poll: f64,
    /// Read an index of at most this many megabytes into memory, so that it is served on while
    /// another is copied over it; a larger one is mapped, and a copy over it turns requests away
    /// until it is whole.
    // 256 MB are read in 0.2 s and searched as fast as mapped ones; indexes for pictures are mostly
    // smaller.
    #[arg(long, value_name = "MB", default_value_t = 256)]
    read_below: u32,
    /// Let people name the grasps of labelled pictures as well, at /quiz/; see `grasp-query quiz`.
    #[arg(long, value_name = "LABELS.csv")]
    quiz: Option<PathBuf>,
    /// Keep the quiz's answers in this table.
    #[arg(long, value_name = "ANSWERS.csv", default_value = "answers.csv", requires = "quiz")]
    quiz_out: PathBuf,
    /// Seconds that requests under way may take after SIGTERM or Ctrl-C.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = parse_seconds, allow_negative_numbers = true)]
    drain: f64,
}

impl Serve {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        let token = self.token_file.as_deref().map(super::token::read).transpose()?;
        let address = self.address();
        if let Some(address) = address.filter(|address| !address.ip().is_loopback())
            && token.is_none()
        {
            bail!(
                "{address} can be reached from other machines: name a file that holds a token with --token-file, or listen at 127.0.0.1"
            );
        }
        let workers = match usize::from(global.threads) {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let quiz = self.quiz.as_deref().map(|labels| self.quiz_table(labels)).transpose()?;
        let service = Service::new(Settings {
            index: self.index.path(),
            most_read: if self.index.is_read() { u64::MAX } else { u64::from(self.read_below) * 1_000_000 },
            workers,
            queue: self.queue.into(),
            most_bytes: usize::from(self.max_body) * 1_000_000,
            most_pixels: u64::from(self.max_pixels) * 1_000_000,
            timeout: Duration::from_secs_f64(self.timeout),
            poll: Duration::from_secs_f64(self.poll),
            drain: Duration::from_secs_f64(self.drain),
            token,
            has_quiz: quiz.is_some(),
        });
        // Requests are worked on by threads that may block: as many as workers, and one to look
        // after the index.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(workers.min(4))
            .max_blocking_threads(workers + 1)
            .enable_all()
            .build()?;
        let ended = runtime.block_on(self.serve(service, quiz, address));
        // Work that was cut short is not waited for.
        runtime.shutdown_background();
        ended
    }

    async fn serve(
        &self,
        service: Arc<Service>,
        quiz: Option<Table>,
        address: Option<SocketAddr>,
    ) -> anyhow::Result<u8> {
        let reloaded = Arc::clone(&service);
        let (stop, interrupted) = signals(Some(move || reloaded.reload()))?;
        let mut listeners = Vec::new();
        let mut names = Vec::new();
        if let Some(address) = address {
            let listener = TcpListener::bind(address)
                .await
                .with_context(|| format!("cannot listen at {address}: name another with --listen"))?;
            names.push(format!("http://{}/", listener.local_addr()?));
            listeners.push(Listener::Tcp(listener));
        }
        #[cfg(unix)]
        let _socket = match &self.unix {
            None => None,
            Some(path) => {
                let (listener, socket) = socket::bind(path).with_context(|| {
                    format!("cannot listen at {}: name another path with --unix", path.display())
                })?;
                names.push(format!("unix:{}", path.display()));
                listeners.push(Listener::Unix(listener));
                Some(socket)
            }
        };
        let index = self.index.path();
        let name = index.display().to_string();
        let report = move |event: Event| {
            let index = printable(&name);
            match event {
                Event::Serving(1) => {
                    let addresses = printable(&names.join(" and ")).into_owned();
                    info!(%index, addresses, generation = 1, "{index} at {addresses}; Ctrl-C ends the service");
                }
                Event::Serving(generation) => {
                    info!(%index, generation, "{index} was replaced: generation {generation}");
                }
                Event::Rejected(problem) => {
                    warn!(%index, "{}; the one before goes on", printable(&problem.to_string()));
                }
                Event::Overwritten => warn!(
                    %index,
                    "{index} was overwritten or cut short in place: requests are turned away until it is whole; `mv` a new \
                     index over the old one, and none is"
                ),
                Event::Unavailable(problem) => {
                    warn!(%index, "{}; requests are turned away", printable(&problem.to_string()));
                }
            }
        };
        if !index.exists() {
            // With the advice on how to build one.
            self.index.open()?;
        }
        let ended = service.run(listeners, quiz.map(router), stop, report).await?;
        Ok(match ended {
            Ended::CutShort(count) => {
                let requests = counted(count, ["request was", "requests were"]);
                warn!(count, "{requests} cut short after {} s", self.drain);
                ERROR
            }
            Ended::Drained if interrupted.load(Ordering::SeqCst) => INTERRUPTED,
            Ended::Drained => SUCCESS,
        })
    }

    /// The quiz's pictures and the program's own answers to them, by the index that lies at the
    /// path now.
    fn quiz_table(&self, labels: &Path) -> anyhow::Result<Table> {
        refuse_overwriting(&self.quiz_out, [labels, self.index.path().as_path()])?;
        let index = self.index.open_for_pictures()?;
        let recogniser = Some(Recogniser::new(&index, RecogniseOptions::default()));
        let options = QuizOptions {
            seed: DEFAULT_SEED,
            limit: usize::MAX,
            labelled_masks: false,
            segment: SegmentParams::default(),
            recogniser,
        };
        let (quiz, _) = make(&Selection::all(labels), &self.quiz_out, &options)?;
        Ok(Table::new(quiz))
    }

    fn address(&self) -> Option<SocketAddr> {
        #[cfg(unix)]
        let is_needed = self.unix.is_none();
        #[cfg(not(unix))]
        let is_needed = true;
        self.listen.or_else(|| DEFAULT_ADDRESS.parse().ok().filter(|_| is_needed))
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.01..=86_400.0).contains(seconds));
    seconds.ok_or_else(|| "a number of seconds from 0.01 to 86400 is needed".into())
}

/// A socket in the file system.
#[cfg(unix)]
mod socket {
    use std::fs::Permissions;
    use std::io;
    use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
    use std::path::{Path, PathBuf};

    use tokio::net::UnixListener;

    /// Removes the socket when the service ends.
    #[derive(Debug)]
    pub(super) struct Socket(PathBuf);

    impl Drop for Socket {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    /// Listens at a path, for the same user only. A socket that a killed service left behind is
    /// taken over; one that answers, and whatever is no socket, is left alone.
    pub(super) fn bind(path: &Path) -> io::Result<(UnixListener, Socket)> {
        let is_left = std::fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket());
        if is_left {
            match std::os::unix::net::UnixStream::connect(path) {
                Ok(_) => return Err(io::Error::other("another service answers there")),
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path)?,
                Err(error) => return Err(error),
            }
        }
        Ok((bind_unseen(path)?, Socket(path.to_owned())))
    }

    /// Listens at a path where the socket appears with its permissions set: until then it lies in a
    /// folder that nobody else may enter.
    fn bind_unseen(path: &Path) -> io::Result<UnixListener> {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        let folder = tempfile::Builder::new().prefix(".").tempdir_in(parent.unwrap_or(Path::new(".")))?;
        let unseen = folder.path().join("s");
        let listener = UnixListener::bind(&unseen)?;
        std::fs::set_permissions(&unseen, Permissions::from_mode(0o600))?;
        // Unlike a file that is renamed, a link takes no other's place.
        std::fs::hard_link(&unseen, path)?;
        Ok(listener)
    }
}
