//! What every end-to-end test stands on: the real binaries, built once, and folders to run them in.
//!
//! `cargo test --workspace` builds this package, but not the programs of its neighbours;
//! [`program`] asks cargo for them, so that a test can never run yesterday's binary.

pub mod boxes;
pub mod browser;
pub mod service;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The two programs that the tests run; each is of the package of its name.
const PACKAGES: [&str; 2] = ["grasp-builder", "grasp-query"];
/// The folders of the profiles that this package itself is built in.
const PROFILES: [&str; 3] = ["debug", "release", "trial"];

/// All packages and a test: so dependencies have the features that `cargo test --workspace` has
/// built them with, and are not compiled once more without those that tests and benchmarks add.
const OF_THE_TESTS: &[&str] = &["--workspace", "--test", "circles"];

/// How the programs are built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Build {
    /// As tests run them.
    Debug,
    /// As they are installed.
    Release,
    /// To be tried on a fresh clone: compiled in two thirds of the time, without the service, the
    /// physics engine and Parquet.
    Trial,
}

impl Build {
    /// The folder of what is built so, and what cargo is asked for.
    fn settings(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Debug => ("debug", OF_THE_TESTS),
            Self::Release => ("release", &["--release"]),
            Self::Trial => ("trial", &["--profile", "trial", "--no-default-features"]),
        }
    }
}

/// The folder that holds the built programs, after cargo has made sure that they are up to date.
///
/// The target folder is the one that cargo uses for this run, `CARGO_TARGET_DIR` included.
///
/// # Panics
/// If cargo cannot build the programs: nothing can be tested then.
pub fn programs(build: Build) -> &'static Path {
    static FOLDERS: [OnceLock<PathBuf>; 3] = [const { OnceLock::new() }; 3];
    FOLDERS[build as usize].get_or_init(|| {
        let (folder, arguments) = build.settings();
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(workspace()).args(["build", "--quiet", "--locked"]).args(arguments);
        for package in PACKAGES {
            cargo.args(["--bin", package]);
            if build != Build::Debug {
                cargo.args(["--package", package]);
            }
        }
        let status = cargo.status().expect("cargo runs");
        assert!(status.success(), "cargo could not build {PACKAGES:?}: {status}");
        target_folder().join(folder)
    })
}

/// A command that runs the debug build of `grasp-builder` or `grasp-query`, free of the caller's
/// own settings.
///
/// # Panics
/// As [`programs`].
#[must_use]
pub fn program(name: &str) -> Command {
    let mut command = Command::new(programs(Build::Debug).join(name));
    command.env_remove("GRASP_INDEX").env("NO_COLOR", "1");
    command
}

/// The workspace's root.
///
/// # Panics
/// Never in a checkout: this package lies in a folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the workspace")
}

/// The sample pictures, with their `labels.csv`.
#[must_use]
pub fn pictures() -> PathBuf {
    workspace().join("tests/pictures")
}

/// `<target>/<profile>` holds this very program, or its `deps` folder does.
fn target_folder() -> PathBuf {
    let own = std::env::current_exe().expect("a running program has a path");
    own.ancestors()
        .find(|folder| folder.file_name().is_some_and(|name| PROFILES.iter().any(|profile| name == *profile)))
        .and_then(Path::parent)
        .map_or_else(|| workspace().join("target"), Path::to_path_buf)
}

/// A small index (6 grasps, 30-degree steps) that the real builder made, shared by the tests of one
/// program run.
///
/// # Panics
/// If it cannot be built.
pub fn small_index() -> &'static Path {
    static INDEX: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = INDEX.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("small.idx");
        let built = run(program("grasp-builder").args(["build", "--step", "30", "--out"]).arg(&path));
        assert_eq!(built.status, 0, "{}", built.stderr);
        (folder, path)
    });
    path
}

/// What a program printed, and how it ended.
#[derive(Debug)]
pub struct Outcome {
    /// The exit status; -1 where a signal ended the program.
    pub status: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Outcome {
    /// Standard output as JSON Lines.
    ///
    /// # Panics
    /// If a line is no JSON.
    #[must_use]
    pub fn json_lines(&self) -> Vec<serde_json::Value> {
        let parse = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error} in {line}"));
        self.stdout.lines().map(parse).collect()
    }
}

/// Runs a command to its end.
///
/// # Panics
/// If it cannot be started, or does not print UTF-8.
pub fn run(command: &mut Command) -> Outcome {
    run_with_input(command, &[])
}

/// Runs a command to its end with `input` on its standard input.
///
/// # Panics
/// As [`run`].
pub fn run_with_input(command: &mut Command, input: &[u8]) -> Outcome {
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
    let mut stdin = child.stdin.take().expect("standard input is a pipe");
    let input = input.to_vec();
    // Written from a thread of its own: a program that answers before it has read everything must
    // not block us, and one that stops reading early has closed the pipe, which is its right.
    let feeder = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = child.wait_with_output().expect("the program ends");
    feeder.join().expect("the feeding thread ends");
    Outcome {
        status: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).expect("standard output is UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("standard error is UTF-8"),
    }
}
