//! An index that is overwritten or cut short while the programs read it: an error, never a wrong
//! answer or a signal.

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use grasp_tests::{pictures, program, run, small_index};

/// What it is called, and what does it.
type Way = (&'static str, fn(&Path));

/// Ways to destroy a file that is mapped.
const WAYS: [Way; 3] = [
    ("truncated to nothing", |path| cut(path, 0)),
    ("truncated to half", |path| cut(path, fs::metadata(path).unwrap().len() / 2)),
    ("overwritten", |path| {
        let mut bytes = fs::read(path).unwrap();
        bytes.reverse();
        fs::write(path, bytes).unwrap();
    }),
];

fn cut(path: &Path, length: u64) {
    File::options().write(true).open(path).unwrap().set_len(length).unwrap();
}

fn copy_of_the_index(folder: &Path) -> PathBuf {
    let path = folder.join("grasp.idx");
    fs::copy(small_index(), &path).unwrap();
    path
}

/// Waits for an end with an error that names the file and says what to do.
fn ends_with_an_error(mut child: Child, how: &str) {
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(2), "{how}: {status}, {said}");
    assert!(said.contains("overwritten or cut short while it was in use"), "{how}: {said}");
    assert_eq!(said.lines().count(), 1, "{how}: {said}");
}

#[test]
fn recognise_ends_with_an_error_and_without_another_answer() {
    let folder = tempfile::tempdir().unwrap();
    let picture = fs::read(pictures().join("segmented/09-pinch.png")).unwrap();
    for (how, destroy) in WAYS {
        let index = copy_of_the_index(folder.path());
        let mut command = program("grasp-query");
        command.args(["recognise", "--segmented", "--json", "-", "--index"]).arg(&index);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        let (mut stdin, stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let mut answers = BufReader::new(stdout).lines();
        // The first frame is answered when it is known to be one of several.
        stdin.write_all(&[&picture[..], &picture[..]].concat()).unwrap();
        for _ in 0..2 {
            assert!(answers.next().unwrap().unwrap().contains("\"grasp\""));
        }
        destroy(&index);
        stdin.write_all(&picture).unwrap();
        drop(stdin);
        assert!(answers.next().is_none(), "{how}");
        ends_with_an_error(child, how);
    }
}

#[test]
fn search_ends_with_an_error_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [queries, pipe, out] = ["q.npy", "pipe.npy", "ids.npy"].map(|name| folder.path().join(name));
    let made = run(program("grasp-builder")
        .args(["queries", "--descriptor", "default", "--count", "50", "--out"])
        .arg(&queries));
    assert_eq!(made.status, 0, "{}", made.stderr);
    let queries = fs::read(queries).unwrap();
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for (how, destroy) in WAYS {
        for wanted in [["--out", out.to_str().unwrap()].as_slice(), &["--neighbours"], &[]] {
            let index = copy_of_the_index(folder.path());
            let mut command = program("grasp-query");
            command.arg("search").arg(&pipe).args(wanted).arg("--index").arg(&index);
            let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
            // Waits for the program to open its end, which it does when the index is open.
            let mut end = File::options().write(true).open(&pipe).unwrap();
            destroy(&index);
            end.write_all(&queries).unwrap();
            drop(end);
            let mut printed = String::new();
            child.stdout.take().unwrap().read_to_string(&mut printed).unwrap();
            assert!(printed.is_empty() && !out.exists(), "{how}: {printed}");
            ends_with_an_error(child, how);
        }
    }
}
