//! `cargo demo`: the whole chain on a fresh clone, by the programs that a user would call.
//!
//! Every step is a command that is printed before it runs, so that the demo is also a first lesson.
//! What it makes lies in `target/demo` and nowhere else.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

use grasp_tests::{Build, pictures, programs, workspace};

/// The index that the demo makes.
const INDEX: &str = "target/demo/grasp.idx";
/// The sample that it shows in more detail.
const SHOWN: &str = "tests/pictures/camera/02-small-diameter.jpg";

fn main() -> ExitCode {
    match demo() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("\nThe demo stopped: {message}");
            ExitCode::FAILURE
        }
    }
}

fn demo() -> Result<(), Box<dyn Error>> {
    eprintln!("Compiling grasp-builder and grasp-query (the first time this takes some minutes) ...");
    let steps = Steps { programs: programs(Build::Trial) };
    // Relative paths keep what is printed short, and let a reader repeat it from the checkout's
    // root.
    std::env::set_current_dir(workspace()).map_err(|error| format!("cannot enter the checkout: {error}"))?;
    let out = Path::new("target/demo");
    std::fs::create_dir_all(out).map_err(|error| format!("cannot make {}: {error}", out.display()))?;

    let started = Instant::now();
    steps.heading("Render 40 hands in six grasps from all sides, and index the views (about a minute)");
    steps.run("grasp-builder", &["build", "--out", INDEX])?;

    steps.heading("Recognise pictures of a hand that the index does not hold");
    let samples = samples()?;
    let mut arguments = vec!["recognise", "--index", INDEX, "--explain", "target/demo/explained/"];
    arguments.extend(samples.iter().map(String::as_str));
    steps.run("grasp-query", &arguments)?;

    steps.heading("From the picture to the robot: a BarrettHand grasps the stick in the same way");
    let robot = ["--robot", "barrett", "--object", "query/data/objects/handle.toml"];
    let camera = ["--camera", "query/data/objects/camera.toml", "--hand", "right"];
    steps.run("grasp-query", &[&["recognise", "--index", INDEX], &robot[..], &camera, &[SHOWN]].concat())?;

    println!("\nDone in {:.0} s. Look at", started.elapsed().as_secs_f64());
    println!("  target/demo/explained/{}.png", SHOWN.replace('/', "_"));
    println!("and try");
    println!("  target/trial/grasp-query recognise {SHOWN} --index {INDEX} --json");
    Ok(())
}

/// The sample camera pictures, relative to the checkout's root, in the order of their names.
fn samples() -> Result<Vec<String>, Box<dyn Error>> {
    let folder = pictures().join("camera");
    let listing =
        std::fs::read_dir(&folder).map_err(|error| format!("cannot list {}: {error}", folder.display()))?;
    let mut names: Vec<PathBuf> = listing.filter_map(|entry| Some(entry.ok()?.path())).collect();
    names.retain(|path| path.extension().is_some_and(|extension| extension == "jpg"));
    names.sort();
    Ok(names
        .iter()
        .filter_map(|path| path.strip_prefix(workspace()).ok())
        .map(|path| path.display().to_string())
        .collect())
}

struct Steps {
    programs: &'static Path,
}

impl Steps {
    #[allow(clippy::unused_self, reason = "reads as a step of the demo")]
    fn heading(&self, text: &str) {
        println!("\n== {text}");
    }

    /// Prints the command and runs it. Exit status 1 means that some picture was not recognised,
    /// which is an answer.
    fn run(&self, program: &str, arguments: &[&str]) -> Result<(), Box<dyn Error>> {
        println!("$ {program} {}", arguments.join(" "));
        std::io::stdout().flush()?;
        let status = Command::new(self.programs.join(program))
            .args(arguments)
            .status()
            .map_err(|error| format!("cannot run {program}: {error}"))?;
        match status.code() {
            Some(0 | 1) => Ok(()),
            _ => Err(format!("{program} ended with {status}").into()),
        }
    }
}
