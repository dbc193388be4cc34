//! Pictures that are made to cost far more than their pixels: through the command line, the service
//! and the builder, each costs at most 20 bytes a pixel and 100 MB, and time in proportion to what
//! the same machine needs for something else just then.
#![cfg(target_os = "linux")]

mod jpeg;
mod others;
mod png;
mod speed;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::Stdio;

use grasp_tests::service::Service;
use grasp_tests::{program, run, small_index};

/// The bytes that a picture may cost, for each of its pixels and besides.
const BYTES_A_PIXEL: u64 = 20;
const BYTES_BESIDES: u64 = 100 << 20;

/// The processor time that a picture may cost on the reference machine of [`speed`]: six
/// times what was measured at most, for each of its pixels, and besides, in milliseconds.
const NANOSECONDS_A_PIXEL: u64 = 200;
const MILLISECONDS_BESIDES: u64 = 2000;

/// How much metadata a hostile picture carries: less than the service's limit of a body.
const BULK: usize = 16 << 20;
/// What the bombs unpack to.
const BOMB: usize = 512 << 20;

/// A picture and what it may cost.
struct Hostile {
    name: String,
    bytes: Vec<u8>,
    /// The pixels that a program may be asked to decode; 0 where it must refuse.
    pixels: u64,
}

impl Hostile {
    fn new(name: impl Into<String>, pixels: u64, bytes: Vec<u8>) -> Self {
        Self { name: name.into(), bytes, pixels }
    }

    /// Asserts what it cost a process whose largest picture so far had so many pixels, on a machine
    /// that is so many times slower.
    fn check(&self, by: &str, cost: Cost, largest: u64, slower: f64) {
        let (name, pixels) = (&self.name, self.pixels);
        let allowed = BYTES_A_PIXEL * largest + BYTES_BESIDES;
        assert!(
            cost.bytes <= allowed,
            "{name} of {pixels} pixels in {} kB cost {by} {} MB",
            self.bytes.len() >> 10,
            cost.bytes >> 20
        );
        let allowed = NANOSECONDS_A_PIXEL * pixels / 1_000_000 + MILLISECONDS_BESIDES;
        let allowed = (slower * allowed as f64) as u64;
        assert!(
            cost.milliseconds <= allowed,
            "{name} of {pixels} pixels cost {by} {} ms of a processor, {allowed} allowed",
            cost.milliseconds
        );
    }
}

/// What a process has cost so far.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// The most memory that it held at once.
    bytes: u64,
    /// Its processor time.
    milliseconds: u64,
}

impl Cost {
    fn of(process: u32) -> Self {
        let status = fs::read_to_string(format!("/proc/{process}/status")).expect("the process runs");
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
        let kilobytes: u64 = peak.trim().trim_end_matches(" kB").parse().expect("a number");
        Self { bytes: kilobytes << 10, milliseconds: speed::milliseconds(&format!("/proc/{process}/stat")) }
    }

    /// Forgets the peak, so that the next is that of the next picture.
    fn reset_peak(process: u32) {
        fs::write(format!("/proc/{process}/clear_refs"), "5").expect("a test may ask that of its own child");
    }
}

fn all() -> impl Iterator<Item = Hostile> {
    png::all().into_iter().chain(jpeg::all()).chain(others::all())
}

/// Recognises one picture and returns its record and what the process had cost by then.
fn recognise(picture: &Path) -> (serde_json::Value, Cost) {
    // Standard input comes after the picture: the program waits for it, and can be looked at.
    let mut child = program("grasp-query")
        .args(["recognise", "--json", "--segmented", "--index"])
        .arg(small_index())
        .arg(picture)
        .arg("-")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("a record");
    let cost = Cost::of(child.id());
    drop(child.stdin.take());
    child.wait().expect("the program ends");
    (serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line} of {picture:?}")), cost)
}

#[test]
fn no_picture_costs_the_command_line_more_than_its_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let slower = speed::slower();
    let mut seen = 0;
    for hostile in all() {
        let path = folder.path().join("picture");
        fs::write(&path, &hostile.bytes).unwrap();
        let (record, cost) = recognise(&path);
        if std::env::var_os("SHOW_COSTS").is_some() {
            let message = record["error"]["message"].as_str().unwrap_or("answered");
            let Cost { bytes, milliseconds } = cost;
            println!("{}\t{}\t{}\t{milliseconds}\t{message}", hostile.name, hostile.pixels, bytes >> 20);
        }
        hostile.check("the command line", cost, hostile.pixels, slower);
        if hostile.pixels == 0 {
            assert!(!record["error"].is_null(), "{} was answered", hostile.name);
        }
        seen += 1;
    }
    assert!(seen >= 200, "only {seen} pictures");
}

#[test]
fn no_picture_costs_the_service_more_than_its_pixels() {
    let service = Service::start(|command| {
        command.args(["--threads", "1", "--index"]).arg(small_index());
    });
    let slower = speed::slower();
    // An allocator may keep what an earlier picture needed.
    let mut largest = 0;
    for hostile in all() {
        largest = hostile.pixels.max(largest);
        Cost::reset_peak(service.id());
        let before = Cost::of(service.id());
        let answer = service.post("/v1/recognise", &hostile.bytes);
        let after = Cost::of(service.id());
        assert!([200, 400, 413, 422].contains(&answer.status), "{}: {}", hostile.name, answer.text());
        let milliseconds = after.milliseconds - before.milliseconds;
        hostile.check("the service", Cost { bytes: after.bytes, milliseconds }, largest, slower);
    }
    assert_eq!(service.get("/healthz").status, 200);
}

/// A build reads the pictures of a set that any program may have written.
#[test]
fn no_picture_costs_a_build_more_than_its_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = "file,grasp,qx,qy,qz,qw\npicture,pinch,0,0,0,1\n";
    fs::write(folder.path().join("manifest.csv"), manifest).unwrap();
    let builder = program("grasp-builder").get_program().to_owned();
    for hostile in png::bombs().into_iter().chain(jpeg::many_scans()) {
        fs::write(folder.path().join("picture"), &hostile.bytes).unwrap();
        // A build ends with its one picture: private memory is limited instead of looked at, the
        // pixels' own included.
        let limit = (BYTES_A_PIXEL * hostile.pixels + BYTES_BESIDES) >> 10;
        let outcome = run(std::process::Command::new("sh")
            .arg("-c")
            .arg(format!("ulimit -d {limit}; exec \"$0\" \"$@\""))
            .arg(&builder)
            .args(["build", "--threads", "1", "--out"])
            .arg(folder.path().join("grasp.idx"))
            .arg(folder.path()));
        assert!([0, 2].contains(&outcome.status), "{}: {}", hostile.name, outcome.stderr);
        assert!(!outcome.stderr.contains("memory"), "{}: {}", hostile.name, outcome.stderr);
    }
}
