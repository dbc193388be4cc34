//! `grasp-query serve` while its index is replaced: every request is answered, and rightly; and
//! while it is overwritten or cut short: no answer is wrong.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use grasp_tests::service::{Response, Service};
use grasp_tests::{pictures, program, run, small_index};

/// Another index than the small one: other views, other answers.
fn other_index(folder: &Path) -> PathBuf {
    let path = folder.join("other.idx");
    let built = run(program("grasp-builder").args(["build", "--step", "45", "--out"]).arg(&path));
    assert_eq!(built.status, 0, "{}", built.stderr);
    path
}

/// A service that maps its index, as a large one is.
fn start(index: &Path, poll: &str) -> Service {
    Service::start(|command| {
        command.arg("--index").arg(index).args(["--poll", poll, "--read-below", "0"]);
    })
}

fn picture() -> Vec<u8> {
    fs::read(pictures().join("segmented/09-pinch.png")).unwrap()
}

fn ask(service: &Service) -> Response {
    service.post("/v1/recognise?segmented=true&hand=right", &picture())
}

/// What the command line says by an index.
fn answer_of(index: &Path) -> String {
    let mut command = program("grasp-query");
    command.args(["recognise", "--segmented", "--hand", "right", "--json", "-", "--index"]).arg(index);
    let outcome = grasp_tests::run_with_input(&mut command, &picture());
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    // A service is given pictures, not a stream's frames.
    outcome.stdout.replacen("\"frame\":0,", "", 1)
}

/// Puts a copy of `from` in the place of `to`, as a builder does.
fn replace(from: &Path, to: &Path) {
    let beside = to.with_extension("new");
    fs::copy(from, &beside).unwrap();
    fs::rename(&beside, to).unwrap();
}

/// What was answered to requests while something else went on.
#[derive(Debug)]
struct Load {
    /// How many answers there were of each index.
    counts: Vec<u64>,
    /// How many were told to come back later.
    lost: u64,
}

/// Asks from several threads while `meanwhile` runs, and checks every answer.
fn under_load(service: &Service, answers: &[String], meanwhile: impl FnOnce()) -> Load {
    let counts: Vec<AtomicU64> = answers.iter().map(|_| AtomicU64::new(0)).collect();
    let lost = AtomicU64::new(0);
    let over = AtomicBool::new(false);
    let by_generation = std::sync::Mutex::new(HashMap::<String, usize>::new());
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                while !over.load(Ordering::SeqCst) {
                    let answer = ask(service);
                    if answer.status == 503 {
                        assert_eq!(answer.json()["error"]["kind"], "not_ready", "{}", answer.text());
                        assert_eq!(answer.header("retry-after"), Some("1"));
                        lost.fetch_add(1, Ordering::SeqCst);
                        // Told to wait a second: some of it, so that the others are not kept from
                        // their answers.
                        std::thread::sleep(Duration::from_millis(10));
                        continue;
                    }
                    assert_eq!(answer.status, 200, "{}", answer.text());
                    let at = answers.iter().position(|expected| *expected == answer.text());
                    let at = at.unwrap_or_else(|| panic!("an answer of no index: {}", answer.text()));
                    counts[at].fetch_add(1, Ordering::SeqCst);
                    // A generation is one index and never another.
                    let generation = answer.header("grasp-index-generation").unwrap().to_owned();
                    let known = *by_generation.lock().unwrap().entry(generation).or_insert(at);
                    assert_eq!(known, at);
                }
            });
        }
        // The others must end also where this fails.
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(meanwhile));
        over.store(true, Ordering::SeqCst);
        if let Err(panic) = outcome {
            std::panic::resume_unwind(panic);
        }
    });
    Load { counts: counts.into_iter().map(AtomicU64::into_inner).collect(), lost: lost.into_inner() }
}

#[test]
fn a_hundred_replacements_under_load_lose_no_request() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    let indexes = [small_index().to_owned(), other_index(folder.path())];
    let answers = indexes.each_ref().map(|index| answer_of(index));
    assert_ne!(answers[0], answers[1]);
    replace(&indexes[0], &served);
    let service = start(&served, "0.01");
    let load = under_load(&service, &answers, || {
        for round in 1..=100 {
            replace(&indexes[round % 2], &served);
            service.wait_until("the replacement", |service| {
                service.metric("grasp_index_generation") > round as f64
            });
            assert_eq!(ask(&service).text(), answers[round % 2], "after replacement {round}");
        }
    });
    assert!(load.lost == 0 && load.counts.iter().all(|&count| count > 20), "{load:?}");
    assert_eq!(service.metric("grasp_index_generation"), 101.0);
    assert_eq!(service.metric("grasp_index_reload_failures_total"), 0.0);
    assert_eq!(service.metric("grasp_panics_total"), 0.0);
}

#[test]
fn a_file_that_cannot_be_used_changes_nothing_and_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    replace(small_index(), &served);
    let mut service = start(&served, "0.01");
    let answer = answer_of(small_index());
    let whole = fs::read(small_index()).unwrap();
    let mut flipped = whole.clone();
    // In the middle of an array: opening does not see it, reading it through does.
    flipped[whole.len() / 2] ^= 0x10;
    let wrong: [(&[u8], &str); 4] = [
        (b"", "empty"),
        (b"no index at all", "not"),
        (&whole[..whole.len() / 2], "truncated"),
        (&flipped, "corrupt"),
    ];
    for (failures, (bytes, says)) in (1u32..).zip(wrong) {
        let broken = folder.path().join("broken");
        fs::write(&broken, bytes).unwrap();
        replace(&broken, &served);
        service.wait_until("the failure", |service| {
            service.metric("grasp_index_reload_failures_total") == f64::from(failures)
        });
        let ready = service.get("/readyz");
        let problem = ready.json()["problem"].as_str().unwrap().to_owned();
        assert!(ready.status == 200 && problem.contains(says), "{problem}");
        assert!(service.line().contains("the one before goes on"));
        assert_eq!(ask(&service).text(), answer);
    }
    fs::remove_file(&served).unwrap();
    service.wait_until("the loss", |service| service.metric("grasp_index_reload_failures_total") == 5.0);
    assert_eq!((ask(&service).text(), service.metric("grasp_index_stale")), (answer.clone(), 1.0));
    // Each is told once, however often it is looked at.
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(service.metric("grasp_index_reload_failures_total"), 5.0);

    replace(small_index(), &served);
    service.wait_until("the sound one", |service| service.metric("grasp_index_generation") == 2.0);
    assert!(service.get("/readyz").json()["problem"].is_null());
    assert_eq!((ask(&service).text(), service.metric("grasp_index_stale")), (answer, 0.0));
}

#[test]
fn a_hangup_opens_the_index_anew() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    replace(small_index(), &served);
    let mut service = start(&served, "86400");
    service.signal("HUP");
    assert!(service.line().ends_with("generation 2"));
    assert_eq!(ask(&service).header("grasp-index-generation"), Some("2"));
}

/// How many entries the served index has, as the service says.
fn entries(service: &Service) -> u64 {
    service.get("/v1/index").json()["entries"].as_u64().unwrap()
}

#[test]
fn an_index_that_grows_and_shrinks_is_picked_up() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let builder = |arguments: &[&str]| {
        let outcome = run(program("grasp-builder").args(arguments).current_dir(folder));
        assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
    };
    let served = folder.join("grasp.idx");
    builder(&["build", "--step", "60", "--stage", "grasp", "--hand-shape", "mean"]);
    let service = start(&served, "0.01");
    let answers_as_the_file = || {
        let (told, expected) = (ask(&service), answer_of(&served));
        assert_eq!((told.status, told.text()), (200, expected.clone()));
        expected
    };
    let first = (entries(&service), answers_as_the_file());

    builder(&["add", "grasp.idx", "--step", "60", "--stage", "grasp", "--hand-shape", "broad"]);
    service.wait_until("the added entries", |service| entries(service) > first.0);
    let grown = (entries(&service), answers_as_the_file());
    assert_ne!(grown.1, first.1);
    let hands = &service.get("/v1/index").json()["hand_shapes"];
    assert_eq!(hands.as_array().unwrap().len(), 2, "{hands}");

    builder(&["remove", "grasp.idx", "--hand-shape", "broad"]);
    service.wait_until("the removal", |service| entries(service) == first.0);
    assert_eq!(answers_as_the_file(), first.1);

    let slender = ["--step", "60", "--stage", "grasp", "--hand-shape", "slender"];
    builder(&[&["add", "grasp.idx", "--segment", "new.idx"], &slender[..]].concat());
    assert_eq!(entries(&service), first.0, "a segment is another file");
    builder(&["compact", "grasp.idx", "new.idx", "--out", "grasp.idx"]);
    service.wait_until("the joined entries", |service| entries(service) > first.0);
    answers_as_the_file();
    assert_eq!(service.metric("grasp_index_generation"), 4.0);
    assert_eq!(service.metric("grasp_index_reload_failures_total"), 0.0);
}

#[test]
fn a_builder_at_work_or_killed_disturbs_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    replace(small_index(), &served);
    let service = start(&served, "0.01");
    let (mut before, other) = (vec![answer_of(small_index())], other_index(folder.path()));
    let build = || {
        let mut command = program("grasp-builder");
        command.args(["build", "--step", "45", "--no-progress", "--out"]).arg(&served);
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        command
    };
    let load = under_load(&service, &before, || {
        for wait in [0, 30, 60, 100, 150, 200, 250, 300] {
            let mut builder = build().spawn().unwrap();
            std::thread::sleep(Duration::from_millis(wait));
            if builder.try_wait().unwrap().is_some() {
                // The builder finished before it could be killed.
                replace(small_index(), &served);
                break;
            }
            let killed = Command::new("kill").args(["-9", &builder.id().to_string()]).status().unwrap();
            assert!(killed.success());
            builder.wait().unwrap();
        }
    });
    assert_eq!(load.lost, 0);
    assert_eq!(service.metric("grasp_index_reload_failures_total"), 0.0);
    let sound = run(program("grasp-builder").arg("verify").arg(&served));
    assert_eq!(sound.status, 0, "{}", sound.stderr);

    before.push(answer_of(&other));
    let generation = service.metric("grasp_index_generation");
    let load = under_load(&service, &before, || {
        assert!(build().status().unwrap().success());
        service.wait_until("the new index", |service| service.metric("grasp_index_generation") > generation);
        assert_eq!(ask(&service).text(), before[1]);
    });
    assert_eq!(load.lost, 0);
}

/// Copies a file over another one, as people do.
fn cp(from: &Path, to: &Path) {
    assert!(Command::new("cp").args([from, to]).status().unwrap().success());
}

/// The same piece by piece, as from another machine: over what is there, or from nothing on.
fn trickle(from: &Path, to: &Path, is_truncated: bool) {
    let bytes = fs::read(from).unwrap();
    let mut file = File::options().write(true).truncate(is_truncated).open(to).unwrap();
    for piece in bytes.chunks(bytes.len().div_ceil(8)) {
        file.write_all(piece).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    file.set_len(bytes.len() as u64).unwrap();
}

fn truncate(path: &Path, length: u64) {
    File::options().write(true).open(path).unwrap().set_len(length).unwrap();
}

#[test]
fn fifty_copies_over_a_mapped_index_under_load_give_no_wrong_answer() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    let indexes = [small_index().to_owned(), other_index(folder.path())];
    let answers = indexes.each_ref().map(|index| answer_of(index));
    replace(&indexes[0], &served);
    let service = start(&served, "0.01");
    let load = under_load(&service, &answers, || {
        for round in 1..=60 {
            let generation = service.metric("grasp_index_generation");
            let from = &indexes[round % 2];
            match round {
                0..=50 => cp(from, &served),
                _ => trickle(from, &served, round % 4 < 2),
            }
            let replaced = |service: &Service| {
                service.metric("grasp_index_generation") > generation && is_ready(service)
            };
            service.wait_until("the copy", replaced);
            assert_eq!(ask(&service).text(), answers[round % 2], "after copy {round}");
        }
    });
    let Load { counts, lost } = &load;
    println!(
        "60 copies over a mapped index: {} requests answered, {lost} turned away",
        counts.iter().sum::<u64>()
    );
    assert!(counts.iter().all(|&count| count > 20) && *lost > 0, "{load:?}");
    assert_eq!(service.metric("grasp_panics_total"), 0.0);
}

#[test]
fn copies_over_an_index_in_memory_lose_no_request() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    let indexes = [small_index().to_owned(), other_index(folder.path())];
    let answers = indexes.each_ref().map(|index| answer_of(index));
    replace(&indexes[0], &served);
    let service = Service::start(|command| {
        command.arg("--index").arg(&served).args(["--poll", "0.01"]);
    });
    let load = under_load(&service, &answers, || {
        for round in 1..=12 {
            let from = &indexes[round % 2];
            if round % 2 == 0 {
                cp(from, &served)
            } else {
                trickle(from, &served, round % 4 == 1)
            }
            service.wait_until("the copy", |service| service.metric("grasp_index_generation") > round as f64);
            assert_eq!(ask(&service).text(), answers[round % 2], "after copy {round}");
        }
        truncate(&served, 0);
        service.wait_until("the failure", |service| service.metric("grasp_index_stale") == 1.0);
        assert!(is_ready(&service));
    });
    assert!(load.lost == 0 && load.counts.iter().all(|&count| count > 10), "{load:?}");
    // What was on its way was not taken for a failure, unless the machine was so busy that the copy
    // stood still.
    let failures = service.metric("grasp_index_reload_failures_total");
    assert!((1.0..4.0).contains(&failures), "{failures}");
}

fn is_ready(service: &Service) -> bool {
    service.get("/readyz").status == 200
}

#[test]
fn a_mapped_index_cut_short_under_load_is_reported_and_served_again_when_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let served = folder.path().join("grasp.idx");
    replace(small_index(), &served);
    let mut service = start(&served, "0.01");
    let answers = [answer_of(small_index())];
    let whole = fs::metadata(&served).unwrap().len();
    for (generation, length, says) in
        [(2, 0, "empty"), (3, whole / 2, "truncated"), (4, whole - 1, "truncated")]
    {
        let lost = under_load(&service, &answers, || {
            truncate(&served, length);
            service.wait_until("the reason", |service| {
                let ready = service.get("/readyz");
                let problem = ready.json()["problem"].as_str().unwrap_or_default().to_owned();
                assert!(ready.status == 200 || ready.json()["state"] == "lost", "{}", ready.text());
                ready.status == 503 && problem.contains(says)
            });
            let refused = ask(&service);
            assert!(refused.status == 503 && refused.text().contains("overwritten or cut short"));
        });
        assert!(lost.lost > 0, "{lost:?}");
        cp(small_index(), &served);
        service.wait_until("the whole file", is_ready);
        assert_eq!(ask(&service).text(), answers[0]);
        // Each is reported once; on a machine that is so busy that the copy stands still, that as
        // well.
        let mut lines = vec![service.line()];
        while !lines[lines.len() - 1].contains("was replaced") {
            lines.push(service.line());
        }
        assert!(lines[0].contains("overwritten or cut short in place"), "{lines:?}");
        assert!(lines[1].contains(says) && lines[1].ends_with("requests are turned away"), "{lines:?}");
        assert!(lines[lines.len() - 1].ends_with(&format!("generation {generation}")), "{lines:?}");
    }
    assert_eq!(service.metric("grasp_panics_total"), 0.0);
}
