//! What every end-to-end test stands on: the real binaries, built once, and folders to run them in.
//!
//! `cargo test --workspace` builds this package, but not the programs of its neighbours; [`program`] asks cargo for
//! them, so that a test can never run yesterday's binary.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The two programs that the tests run.
const PACKAGES: [&str; 2] = ["grasp-builder", "grasp-query"];

/// The folder that holds the built programs, after cargo has made sure that they are up to date.
///
/// `release` picks the profile. The target folder is the one that cargo uses for this run, `CARGO_TARGET_DIR` included.
///
/// # Panics
/// If cargo cannot build the programs: nothing can be tested then.
pub fn programs(release: bool) -> &'static Path {
    static DEBUG: OnceLock<PathBuf> = OnceLock::new();
    static RELEASE: OnceLock<PathBuf> = OnceLock::new();
    let folder = if release { &RELEASE } else { &DEBUG };
    folder.get_or_init(|| {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(workspace()).args(["build", "--quiet", "--locked"]);
        for package in PACKAGES {
            cargo.args(["--package", package, "--bin", package]);
        }
        if release {
            cargo.arg("--release");
        }
        let status = cargo.status().expect("cargo runs");
        assert!(status.success(), "cargo could not build {PACKAGES:?}: {status}");
        target_folder().join(if release { "release" } else { "debug" })
    })
}

/// A command that runs the debug build of `grasp-builder` or `grasp-query`, free of the caller's own settings.
///
/// # Panics
/// As [`programs`].
#[must_use]
pub fn program(name: &str) -> Command {
    let mut command = Command::new(programs(false).join(name));
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
        .find(|folder| folder.file_name().is_some_and(|name| name == "debug" || name == "release"))
        .and_then(Path::parent)
        .map_or_else(|| workspace().join("target"), Path::to_path_buf)
}
