//! What a person reads: help texts, and the reports of `inspect` and `verify`, kept as snapshots.

use grasp_tests::{program, run, small_index};

fn help(name: &str, arguments: &[&str]) -> String {
    let outcome = run(program(name).args(arguments).arg("--help").env("COLUMNS", "110"));
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    outcome.stdout
}

#[test]
fn help_texts() {
    insta::assert_snapshot!("builder", help("grasp-builder", &[]));
    insta::assert_snapshot!("builder_build", help("grasp-builder", &["build"]));
    insta::assert_snapshot!("builder_merge", help("grasp-builder", &["merge"]));
    insta::assert_snapshot!("builder_split", help("grasp-builder", &["split"]));
    insta::assert_snapshot!("builder_export", help("grasp-builder", &["export"]));
    insta::assert_snapshot!("builder_remove", help("grasp-builder", &["remove"]));
    insta::assert_snapshot!("builder_compact", help("grasp-builder", &["compact"]));
    insta::assert_snapshot!("builder_train", help("grasp-builder", &["train"]));
    insta::assert_snapshot!("builder_experiment_scale", help("grasp-builder", &["experiment", "scale"]));
    insta::assert_snapshot!("query", help("grasp-query", &[]));
    insta::assert_snapshot!("query_recognise", help("grasp-query", &["recognise"]));
    insta::assert_snapshot!("query_watch", help("grasp-query", &["watch"]));
    insta::assert_snapshot!("query_search", help("grasp-query", &["search"]));
    insta::assert_snapshot!("query_evaluate", help("grasp-query", &["evaluate"]));
    insta::assert_snapshot!("query_experiment_paper", help("grasp-query", &["experiment", "paper"]));
    let networks = help("grasp-builder", &["experiment", "networks"]);
    insta::assert_snapshot!("builder_experiment_networks", networks);
    insta::assert_snapshot!("builder_experiment_shapes", help("grasp-builder", &["experiment", "shapes"]));
    insta::assert_snapshot!("query_experiment_shapes", help("grasp-query", &["experiment", "shapes"]));
    insta::assert_snapshot!("query_experiment_unknown", help("grasp-query", &["experiment", "unknown"]));
    for name in ["trust", "robustness", "imitation", "report", "steadiness"] {
        insta::assert_snapshot!(
            format!("query_experiment_{name}"),
            help("grasp-query", &["experiment", name])
        );
    }
    insta::assert_snapshot!("query_simulate", help("grasp-query", &["simulate"]));
    insta::assert_snapshot!("query_quiz", help("grasp-query", &["quiz"]));
    insta::assert_snapshot!("query_serve", help("grasp-query", &["serve"]));
}

#[test]
fn inspect_says_what_is_in_an_index() {
    let outcome = run(program("grasp-builder").arg("inspect").arg(small_index()));
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    // What is measured may differ in the last digits from one kind of machine to another.
    let filters = vec![
        (r"/\S*/small.idx", "small.idx"),
        (r"[0-9a-f]{16}", "[hash]"),
        (r"(  effort .*\n)+", "  effort       [...]\n"),
        (r"\b[01]\.\d{3,4}\b", "[share]"),
        (r"(  vote .*\n)+", "  vote         [...]\n"),
        (r"printed: \d+\.\d", "printed: [sigma]"),
        (r"(?m)^  section .*$", "  section      [...]"),
        (r"[\d,]+ bytes", "[n] bytes"),
    ];
    insta::with_settings!({filters => filters}, {
        insta::assert_snapshot!("inspect", outcome.stdout);
    });
    let json = run(program("grasp-builder").args(["inspect", "--json"]).arg(small_index()));
    let report = &json.json_lines()[0];
    assert_eq!(report["classes"].as_array().unwrap().len(), 6);
    assert_eq!(report["descriptor"]["dim"], 340);
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let builder = program("grasp-builder").get_program().to_owned();
    let piped = run(std::process::Command::new("bash")
        .args(["-c", "\"$0\" completions bash | head -n 1 >/dev/null; echo ${PIPESTATUS[0]}"])
        .arg(builder));
    assert_eq!((piped.stdout.as_str(), piped.stderr.as_str()), ("0\n", ""));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_output_is_called_that() {
    for (name, arguments) in [
        ("grasp-builder", ["inspect", "--help"].as_slice()),
        ("grasp-query", &["--version"]),
        ("grasp-query", &["completions", "bash"]),
    ] {
        let mut command = program(name);
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let ended = command.args(arguments).stdout(full).output().unwrap();
        let stderr = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {stderr}");
        let said = format!("{name}: cannot write to standard output: No space left on device");
        assert!(stderr.starts_with(&said), "{arguments:?}: {stderr}");
    }
}

#[test]
fn completions_and_manual_pages_come_for_both_programs() {
    for (name, subcommand, option) in
        [("grasp-builder", "build", "thumbnails"), ("grasp-query", "recognise", "segmented")]
    {
        let completions = run(program(name).args(["completions", "zsh"]));
        assert!(
            completions.status == 0 && completions.stdout.contains(&format!("#compdef {name}")),
            "{name}"
        );
        let page = run(program(name).arg("man"));
        assert!(page.status == 0 && page.stdout.contains(subcommand), "{name}");
        let page = run(program(name).args(["man", subcommand]));
        assert!(page.status == 0 && page.stdout.contains(option), "{name} {subcommand}");
        assert_eq!(run(program(name).args(["man", "nothing"])).status, 2);
    }
}
