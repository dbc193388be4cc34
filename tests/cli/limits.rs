//! Limits of the machine: a build holds little in memory, and where it is stopped or the disk is
//! full nothing half-written stays.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use grasp_index::Index;
use grasp_index::npy::{NpyHeader, NpyType};
use grasp_tests::{Outcome, program, run, small_index};

const ROWS: usize = 100_000;
const DIM: usize = 256;
/// What the rows are spread out by: as with descriptors, far fewer directions than values.
const DIRECTIONS: usize = 8;
/// The bytes that a build may hold for each row: twice its codes, on their way from one order to
/// another, and its label.
const HELD_A_ROW: usize = 300;
/// What it may hold besides: buffers, the threads' stacks, the program's own data.
const HELD_BESIDES: usize = 40 << 20;

/// Numbers from -1 to 1, always the same.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// A folder with 102 MB of vectors in `x.npy` and their labels in `y.csv`.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let make = || {
        let folder = tempfile::tempdir().unwrap();
        let mut out = BufWriter::new(File::create(folder.path().join("x.npy")).unwrap());
        let (rows, columns) = (ROWS as u64, DIM as u64);
        out.write_all(&NpyHeader { element: NpyType::F32, rows, columns, offset: 0 }.to_bytes()).unwrap();
        let mut noise = Noise(1);
        let directions: Vec<f32> = (0..DIRECTIONS * DIM).map(|_| noise.next()).collect();
        let mut row = [0.0; DIM];
        for _ in 0..ROWS {
            row.fill_with(|| 0.05 * noise.next());
            for direction in directions.chunks_exact(DIM) {
                let along = noise.next();
                row.iter_mut().zip(direction).for_each(|(value, step)| *value += along * step);
            }
            row.iter().for_each(|value| out.write_all(&value.to_le_bytes()).unwrap());
        }
        out.flush().unwrap();
        let line = |row: usize| ["pinch\n", "power-sphere\n"][row % 2];
        let labels: String = std::iter::once("grasp\n").chain((0..ROWS).map(line)).collect();
        fs::write(folder.path().join("y.csv"), labels).unwrap();
        folder
    };
    FOLDER.get_or_init(make).path()
}

/// The builder under one of the shell's limits, `ulimit` with these arguments.
fn limited(limit: &str, arguments: &[&str], folder: &Path) -> Outcome {
    let builder = program("grasp-builder").get_program().to_owned();
    // Ignoring the signal makes a write fail instead, as it does on a full disk.
    let script = format!("trap '' XFSZ; ulimit {limit}; exec \"$0\" \"$@\"");
    run(Command::new("sh").args(["-c", &script]).arg(builder).args(arguments).current_dir(folder))
}

fn files_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_build_holds_the_quantised_form_of_its_vectors_and_no_more() {
    let out = tempfile::tempdir().unwrap();
    let (x, y) = (folder().join("x.npy"), folder().join("y.csv"));
    let built = |limit: usize, hash: &[&str]| {
        let files = ["--descriptors", x.to_str().unwrap(), "--labels", y.to_str().unwrap()];
        // Private memory that can be written; what is mapped from files does not count, because it
        // can be dropped.
        let arguments = [&["build", "--out", "big.idx", "--threads", "2"][..], &files, hash].concat();
        limited(&format!("-d {}", limit >> 10), &arguments, out.path())
    };
    let all = ROWS * DIM * 4;
    let limit = ROWS * HELD_A_ROW + HELD_BESIDES;
    assert!(limit < all, "a limit that the vectors themselves fit into shows nothing");
    let random = ["--hash", "random", "--tables", "4", "--planes", "14"];
    for hash in [&random[..], &["--originals", "none"]] {
        let outcome = built(limit, hash);
        assert_eq!(outcome.status, 0, "{hash:?}: {}", outcome.stderr);
        assert_eq!(files_in(out.path()), ["big.idx"]);
        let index = Index::open(out.path().join("big.idx")).unwrap();
        assert_eq!((index.len(), index.dim()), (ROWS, DIM));
        assert!(index.verify().is_sound());
    }
    // The limit is enforced.
    assert_ne!(built(4 << 20, &random).status, 0);
}

#[test]
fn a_build_that_is_stopped_leaves_nothing() {
    let out = tempfile::tempdir().unwrap();
    let mut child = program("grasp-builder")
        .args(["build", "--out", "big.idx", "--descriptors"])
        .arg(folder().join("x.npy"))
        .current_dir(out.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // In the midst of the writing.
    let part = out.path().join(".big.idx.part");
    let started = Instant::now();
    while fs::metadata(&part).map_or(0, |part| part.len()) < 1 << 20 {
        assert!(started.elapsed() < Duration::from_secs(60), "no part is written");
        std::thread::sleep(Duration::from_millis(1));
    }
    let stopped = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert_eq!(files_in(out.path()), [""; 0]);
}

#[test]
fn a_full_disk_leaves_what_was_there() {
    let out = tempfile::tempdir().unwrap();
    let there = ["x.npy", "y.csv", "grasp.idx"];
    for name in &there[..2] {
        fs::write(out.path().join(name), "old").unwrap();
    }
    fs::copy(small_index(), out.path().join("grasp.idx")).unwrap();
    let index = fs::read(out.path().join("grasp.idx")).unwrap();
    let vectors = folder().join("x.npy").display().to_string();
    for arguments in [
        &["build", "--out", "grasp.idx", "--descriptors", &vectors][..],
        &["build", "--out", "grasp.idx", "--step", "30", "--seed", "8"],
        &["export", "grasp.idx", "--descriptors", "x.npy"],
        &["export", "grasp.idx", "--labels", "y.csv"],
        &["export", "grasp.idx", "--parquet", "y.csv"],
        &["queries", "--count", "60", "--out", "x.npy"],
    ] {
        // 16 blocks of 512 bytes.
        let outcome = limited("-f 16", arguments, out.path());
        assert_eq!(outcome.status, 2, "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
        assert!(outcome.stderr.contains("cannot write"), "{arguments:?}: {}", outcome.stderr);
        assert_eq!(files_in(out.path()), ["grasp.idx", "x.npy", "y.csv"]);
        assert!(fs::read(out.path().join("grasp.idx")).unwrap() == index);
        assert!(there[..2].iter().all(|name| fs::read(out.path().join(name)).unwrap() == b"old"));
    }
}
