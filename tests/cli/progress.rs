//! Long work reports how far it has come where no terminal is, and says what is kept when it is
//! stopped.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use grasp_tests::program;

/// Work that takes minutes, in `folder`.
fn start(arguments: &[&str], folder: &Path) -> Child {
    program("grasp-builder")
        .args(arguments)
        .args(["--threads", "1"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("grasp-builder starts")
}

/// Sends Ctrl-C and returns the rest of standard error.
fn stop(mut child: Child) -> String {
    let stopped = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    let mut rest = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    rest
}

/// Waits until work is under way: a file whose name ends like this is there.
fn wait_for(folder: &Path, ending: &str) {
    let started = Instant::now();
    let is_there = || {
        let mut entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.any(|entry| entry.file_name().to_string_lossy().ends_with(ending))
    };
    while !is_there() {
        assert!(started.elapsed() < Duration::from_secs(60), "nothing ends in {ending}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_long_build_logs_how_far_it_is_and_ctrl_c_says_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let build = |out, more: &[&str]| {
        start(&[&["build", "--preset", "wide", "--out", out][..], more].concat(), folder.path())
    };
    let silent = build("silent.idx", &["--no-progress"]);
    let mut logged = build("grasp.idx", &[]);
    let started = Instant::now();
    let mut line = String::new();
    BufReader::with_capacity(1, logged.stderr.as_mut().expect("a pipe")).read_line(&mut line).unwrap();
    let waited = started.elapsed();
    assert!((5..60).contains(&waited.as_secs()), "{waited:?}");
    let starts = line.starts_with("grasp-builder: describing: ");
    assert!(starts && line.contains(" of 669,600 views ("), "{line}");
    // On a busy machine nothing may be done yet, and then there is no pace.
    let has_pace =
        (line.contains(" a second, ") || line.contains(" each, ")) && line.trim_end().ends_with(" left");
    assert!(has_pace || line.ends_with("0 %), 10 s so far\n"), "{line}");

    let said = stop(logged);
    assert!(said.contains("nothing of this build is kept, and grasp.idx is not written"), "{said}");
    assert!(
        said.contains("`grasp-builder shard --shard I/12") && said.contains("`grasp-builder merge"),
        "{said}"
    );
    let silence = stop(silent);
    assert!(silence.starts_with("grasp-builder: stopped: "), "{silence}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn ctrl_c_says_of_each_kind_of_work_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (renders, parts) = (folder.path().join("renders"), folder.path().join("parts"));
    let shard = start(&["shard", "--shard", "1/2", "--preset", "wide", "--out", "parts"], folder.path());
    wait_for(&parts, ".part");
    assert!(stop(shard).contains("nothing of this part is kept, and parts that are finished stay"));
    let render = start(&["render", "--hands", "50", "--out", "renders"], folder.path());
    wait_for(&renders, "");
    assert!(stop(render).contains("what is rendered is kept; run the same command again"));
}
