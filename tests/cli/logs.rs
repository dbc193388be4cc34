//! `--log json`: every line on standard error is an object, and says of long work and of a service
//! what a collector of logs wants to know. Without it, nothing new is said.

use std::process::Command;

use grasp_tests::service::{Service, request};
use grasp_tests::{Outcome, pictures, program, run, small_index};
use serde_json::Value;

/// The events on standard error, each checked for what every event has.
fn events(outcome: &Outcome) -> Vec<Value> {
    outcome.stderr.lines().map(event).collect()
}

fn event(line: &str) -> Value {
    let event: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
    for key in ["timestamp", "level", "target", "message"] {
        assert!(event[key].is_string(), "{key}: {line}");
    }
    event
}

fn builder(arguments: &[&str]) -> Command {
    let mut command = program("grasp-builder");
    command.args(arguments);
    command
}

/// The events that say that a phase has ended.
fn ended<'a>(events: &'a [Value], phase: &str) -> &'a Value {
    let found = events.iter().find(|event| event["phase"] == phase && event["state"] == "ended");
    found.unwrap_or_else(|| panic!("{phase} does not end in {events:#?}"))
}

#[test]
fn a_build_says_how_long_each_phase_took_and_what_it_counted() {
    let folder = tempfile::tempdir().unwrap();
    let build = |more: &[&str]| {
        run(builder(&["build", "--step", "45", "--out", "a.idx"]).args(more).current_dir(folder.path()))
    };
    let built = build(&["--log", "json"]);
    assert_eq!(built.status, 0, "{}", built.stderr);
    assert!(built.stdout.starts_with("a.idx: "), "{}", built.stdout);
    let events = events(&built);
    let described = ended(&events, "describing");
    assert_eq!(described["unit"], "views");
    assert_eq!(described["done"], described["total"]);
    assert!(described["done"].as_u64().unwrap() > 0 && described["seconds"].as_f64().unwrap() > 0.0);
    for phase in ["rendering held-out hands", "choosing the hash", "measuring the search"] {
        assert!(ended(&events, phase)["seconds"].is_f64());
    }
    let (first, last) = (events.first().unwrap(), events.last().unwrap());
    assert_eq!((&first["phase"], &first["state"]), (&"build".into(), &"began".into()));
    assert_eq!((&last["phase"], &last["status"]), (&"build".into(), &0.into()));

    // By default a short build says nothing beside its report; from debug on, people see the
    // phases.
    std::fs::remove_file(folder.path().join("a.idx")).unwrap();
    assert_eq!(build(&[]).stderr, "");
    std::fs::remove_file(folder.path().join("a.idx")).unwrap();
    let told = build(&["--log-level", "debug"]).stderr;
    assert!(told.starts_with("grasp-builder: build begins\n"), "{told}");
    assert!(told.contains("\ngrasp-builder: describing: ") && told.contains(" views in "), "{told}");
}

#[test]
fn shards_and_their_merge_say_what_they_did() {
    let folder = tempfile::tempdir().unwrap();
    let done = |arguments: &[&str]| {
        let done = run(builder(arguments).args(["--log", "json"]).current_dir(folder.path()));
        assert_eq!(done.status, 0, "{}", done.stderr);
        events(&done)
    };
    for part in ["1/2", "2/2"] {
        let events = done(&["shard", "--shard", part, "--step", "45", "--out", "parts"]);
        assert!(ended(&events, "describing")["done"].as_u64().unwrap() > 0);
    }
    let merged = done(&["merge", "parts", "--out", "a.idx"]);
    assert_eq!(ended(&merged, "merging")["done"], 2);
    assert_eq!(ended(&merged, "merge")["status"], 0);
}

#[test]
fn an_error_is_an_event_and_a_level_leaves_out_what_is_below() {
    let missing = run(&mut builder(&["inspect", "none.idx", "--log", "json", "--log-level", "error"]));
    assert_eq!(missing.status, 2);
    let [error] = &events(&missing)[..] else { panic!("{}", missing.stderr) };
    assert_eq!((&error["level"], &error["subject"]), (&"ERROR".into(), &"grasp-builder".into()));
    assert!(error["message"].as_str().unwrap().starts_with("cannot inspect none.idx"), "{error}");
    let text = run(&mut builder(&["inspect", "none.idx"]));
    assert!(text.stderr.starts_with("grasp-builder: cannot inspect none.idx"), "{}", text.stderr);
}

#[test]
fn a_picture_without_an_answer_is_an_event() {
    let recognise = |more: &[&str]| {
        let mut command = program("grasp-query");
        command.args(["recognise", "--index"]).arg(small_index()).arg(pictures().join("labels.csv"));
        run(command.args(more))
    };
    let (json, text) = (recognise(&["--log", "json"]), recognise(&[]));
    assert_eq!((json.status, text.status), (2, 2));
    assert_eq!((&*json.stdout, &*text.stdout), ("", ""));
    let events = events(&json);
    let error = events.iter().find(|event| event["level"] == "ERROR").expect("an error");
    assert!(error["file"].as_str().unwrap().ends_with("labels.csv"), "{error}");
    // The same words, and nothing else, for people; and they are not left out with what is less.
    assert_eq!(text.stderr, format!("{}\n", error["message"].as_str().unwrap()));
    assert_eq!(recognise(&["--log-level", "error"]).stderr, text.stderr);
    assert_eq!(ended(&events, "recognise")["status"], 2);
}

#[test]
fn a_service_logs_its_start_requests_reloads_and_end() {
    let folder = tempfile::tempdir().unwrap();
    let index = folder.path().join("served.idx");
    std::fs::copy(small_index(), &index).unwrap();
    let mut service = Service::start(|command| {
        command.args(["--log", "json", "--log-level", "debug", "--poll", "0.05", "--index"]).arg(&index);
    });
    let answer = service.send(&request("GET", "/v1/index?x=secret", "X-Request-Id: a7\r\n", b""));
    assert_eq!(answer.status, 200);
    let mut until = |what: &str, is_it: &dyn Fn(&Value) -> bool| loop {
        let line = service.line();
        assert!(!line.contains("secret"), "{what}: {line}");
        let event = event(&line);
        if is_it(&event) {
            return event;
        }
    };
    let asked = until("the request", &|event| event["path"] == "/v1/index");
    assert_eq!((&asked["method"], &asked["status"]), (&"GET".into(), &200.into()));
    assert_eq!((&asked["level"], &asked["request_id"]), (&"DEBUG".into(), &"a7".into()));
    assert!(asked["ms"].as_f64().unwrap() > 0.0);

    let beside = folder.path().join("new.idx");
    std::fs::copy(small_index(), &beside).unwrap();
    std::fs::rename(&beside, &index).unwrap();
    assert_eq!(until("the reload", &|event| event["generation"] == 2)["level"], "INFO");
    std::fs::write(&beside, "no index").unwrap();
    std::fs::rename(&beside, &index).unwrap();
    let refused = until("what is no index", &|event| event["level"] == "WARN");
    assert!(refused["message"].as_str().unwrap().ends_with("the one before goes on"), "{refused}");

    service.signal("TERM");
    assert_eq!(service.wait(), 0);
    let rest: Vec<Value> = std::iter::from_fn(|| service.next_line()).map(|line| event(&line)).collect();
    assert!(rest.iter().any(|event| event["phase"] == "draining"), "{rest:?}");
    assert_eq!(ended(&rest, "serve")["status"], 0);
}
