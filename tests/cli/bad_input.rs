//! Bad input gets a clear error and the right exit status, and the good input beside it is answered
//! all the same.

use std::fs;
use std::path::{Path, PathBuf};

use grasp_tests::{Outcome, pictures, program, run, small_index};

fn recognise(arguments: &[&Path]) -> Outcome {
    run(program("grasp-query")
        .args(["recognise", "--json", "--segmented", "--index"])
        .arg(small_index())
        .args(arguments))
}

fn good() -> PathBuf {
    let mut labels = csv::Reader::from_path(pictures().join("labels.csv")).unwrap();
    let row = labels.records().map(Result::unwrap).find(|row| &row[2] == "segmented").unwrap();
    pictures().join(&row[0])
}

/// Recognises a bad file between two good ones and returns its error; the good ones must be
/// answered.
fn error_between_good_ones(bad: &Path, status: i32) -> String {
    let outcome = recognise(&[&good(), bad, &good()]);
    assert_eq!(outcome.status, status, "{}{}", outcome.stdout, outcome.stderr);
    let records = outcome.json_lines();
    assert_eq!(records.len(), 3);
    assert!(records[0]["error"].is_null() && records[2]["error"].is_null(), "{records:?}");
    assert_eq!(records[0]["grasp"], records[2]["grasp"]);
    records[1]["error"]["message"].as_str().unwrap_or_else(|| panic!("no error in {}", records[1])).to_owned()
}

#[test]
fn what_is_not_an_image_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("notes.png");
    fs::write(&text, "not a picture at all").unwrap();
    assert!(error_between_good_ones(&text, 2).contains("not a picture"));
    let missing = folder.path().join("missing.png");
    assert!(error_between_good_ones(&missing, 2).to_lowercase().contains("no such file"));
    let empty = folder.path().join("empty.png");
    fs::write(&empty, "").unwrap();
    error_between_good_ones(&empty, 2);
}

#[test]
fn a_truncated_image_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(good()).unwrap();
    let truncated = folder.path().join("truncated.png");
    fs::write(&truncated, &whole[..whole.len() / 2]).unwrap();
    error_between_good_ones(&truncated, 2);
}

#[test]
fn a_picture_without_a_hand_is_rejected_with_status_1() {
    let folder = tempfile::tempdir().unwrap();
    let black = folder.path().join("black.png");
    image::GrayImage::new(64, 64).save(&black).unwrap();
    assert!(error_between_good_ones(&black, 1).contains("no hand: the picture is all black"));
}

#[test]
fn a_gigantic_header_is_refused_before_decoding() {
    let folder = tempfile::tempdir().unwrap();
    let huge = folder.path().join("huge.ppm");
    fs::write(&huge, "P6\n30000 30000\n255\n").unwrap();
    let message = error_between_good_ones(&huge, 2);
    assert!(message.contains("30000"), "{message}");
}

#[test]
fn a_wrong_index_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("wrong.idx");
    fs::write(&wrong, fs::read(good()).unwrap()).unwrap();
    for program_and_arguments in
        [["grasp-query", "recognise"], ["grasp-builder", "verify"], ["grasp-builder", "inspect"]]
    {
        let [name, subcommand] = program_and_arguments;
        let mut command = program(name);
        command.arg(subcommand);
        if name == "grasp-query" {
            command.arg(good()).arg("--index");
        }
        let outcome = run(command.arg(&wrong));
        assert_eq!(outcome.status, 2, "{program_and_arguments:?}");
        assert!(outcome.stderr.contains("not a grasp index"), "{}", outcome.stderr);
    }
    let outcome = run(program("grasp-query").arg("recognise").arg(good()).current_dir(folder.path()));
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("grasp-builder build"), "{}", outcome.stderr);
}

#[test]
fn an_index_cut_or_flipped_anywhere_is_found_by_verify() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fs::read(small_index()).unwrap();
    let broken = folder.path().join("broken.idx");
    // Every length and every byte is the index crate's own sweep; here a few, through the program.
    for length in [0, 1, 63, 64, 4096, whole.len() / 2, whole.len() - 1] {
        fs::write(&broken, &whole[..length]).unwrap();
        let outcome = run(program("grasp-builder").arg("verify").arg(&broken));
        assert_eq!(outcome.status, 2, "cut to {length}: {}", outcome.stdout);
    }
    for at in (0..whole.len()).step_by(whole.len() / 16) {
        let mut flipped = whole.clone();
        flipped[at] ^= 0x10;
        fs::write(&broken, &flipped).unwrap();
        let outcome = run(program("grasp-builder").arg("verify").arg(&broken));
        assert_eq!(outcome.status, 2, "byte {at}: {}", outcome.stdout);
    }
    assert_eq!(run(program("grasp-builder").arg("verify").arg(small_index())).status, 0);
}

#[test]
fn a_manifest_whose_file_is_missing_stops_the_build_and_keeps_the_old_index() {
    let folder = tempfile::tempdir().unwrap();
    let (set, index) = (folder.path().join("set"), folder.path().join("grasp.idx"));
    let render =
        |set: &Path| run(program("grasp-builder").args(["render", "--step", "45", "--out"]).arg(set));
    let build = || run(program("grasp-builder").arg("build").arg(&set).arg("--out").arg(&index));
    assert_eq!(render(&set).status, 0);
    assert_eq!(build().status, 0);
    let before = fs::read(&index).unwrap();

    let mut manifest = csv::Reader::from_path(set.join("manifest.csv")).unwrap();
    let file = manifest.records().nth(3).unwrap().unwrap()[0].to_owned();
    fs::remove_file(set.join(&file)).unwrap();
    let outcome = build();
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains(file.rsplit('/').next().unwrap()), "{}", outcome.stderr);
    assert!(fs::read(&index).unwrap() == before);

    // `render` puts back what is missing, and nothing else.
    assert_eq!(render(&set).status, 0);
    assert_eq!(build().status, 0);
    assert!(fs::read(&index).unwrap() == before);
}

#[test]
fn broken_rows_of_a_table_of_labels_are_named_and_the_others_scored() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(good(), folder.path().join("good.png")).unwrap();
    let rows = "file,kind,grasp\ngood.png,segmented,large-diameter\ngood.png,segmented,lateral\n\
                gone.png,segmented,pinch\ngood.png,etched,pinch\n";
    fs::write(folder.path().join("labels.csv"), rows).unwrap();
    // By its bare name: the pictures lie beside it.
    let outcome = run(program("grasp-query")
        .args(["evaluate", "labels.csv", "--json", "--index"])
        .arg(small_index())
        .current_dir(folder.path()));
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    let report = &outcome.json_lines()[0];
    assert_eq!(report["n"], 1, "{report}");
    let mut lines: Vec<u64> =
        report["errors"].as_array().unwrap().iter().map(|error| error["line"].as_u64().unwrap()).collect();
    lines.sort_unstable();
    assert_eq!(lines, [3, 4, 5], "{report}");
    assert!(report["errors"].to_string().contains("`lateral` is not one of the classes"), "{report}");
}

#[test]
fn build_does_not_overwrite_what_is_no_index() {
    let folder = tempfile::tempdir().unwrap();
    let thesis = folder.path().join("thesis.txt");
    fs::write(&thesis, "three years of work").unwrap();
    let outcome = run(program("grasp-builder").args(["build", "--step", "45", "--out"]).arg(&thesis));
    assert_eq!(outcome.status, 2);
    assert_eq!(fs::read_to_string(&thesis).unwrap(), "three years of work");
    assert!(outcome.stderr.contains("not a grasp index"), "{}", outcome.stderr);
}

#[test]
fn an_answer_stands_where_its_drawing_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let drawing = folder.path().join("missing/why.png");
    let outcome = recognise(&[&good(), Path::new("--explain"), &drawing]);
    assert_eq!(outcome.status, 2);
    assert!(!outcome.json_lines()[0]["grasp"].is_null(), "{}", outcome.stdout);
    assert!(outcome.stderr.contains("why.png"), "{}", outcome.stderr);
}

#[test]
fn no_output_overwrites_an_input() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("picture.png");
    fs::copy(good(), &picture).unwrap();
    let labels = folder.path().join("labels.csv");
    fs::write(&labels, "file,kind,grasp\npicture.png,segmented,large-diameter\n").unwrap();
    let table = folder.path().join("unknown.csv");
    fs::copy(&labels, &table).unwrap();
    for (arguments, input) in [
        (["recognise", "--segmented", "picture.png", "--explain", "./picture.png"], &picture),
        (["evaluate", "labels.csv", "--json", "--predictions", "labels.csv"], &labels),
        (["evaluate", "labels.csv", "--json", "--predictions", "picture.png"], &picture),
        (["experiment", "unknown", "unknown.csv", "--others=unknown.csv", "--out=."], &table),
    ] {
        let before = fs::read(input).unwrap();
        let outcome = run(program("grasp-query")
            .args(arguments)
            .arg("--index")
            .arg(small_index())
            .current_dir(folder.path()));
        assert_eq!(outcome.status, 2, "{arguments:?}");
        assert!(outcome.stderr.contains("is an input as well"), "{}", outcome.stderr);
        assert!(fs::read(input).unwrap() == before, "{arguments:?}");
    }
}

#[test]
fn render_leaves_a_set_that_another_program_made_alone() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(good(), folder.path().join("mine.png")).unwrap();
    let manifest = "file,grasp,qx,qy,qz,qw\nmine.png,pinch,0,0,0,1\n";
    fs::write(folder.path().join("manifest.csv"), manifest).unwrap();
    let outcome = run(program("grasp-builder").args(["render", "--step", "90", "--out"]).arg(folder.path()));
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("another program"), "{}", outcome.stderr);
    assert_eq!(fs::read_to_string(folder.path().join("manifest.csv")).unwrap(), manifest);
}

#[test]
fn a_plan_of_millions_of_views_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(program("grasp-builder")
        .args(["render", "--step", "0.5", "--rolls", "360", "--out"])
        .arg(folder.path().join("huge")));
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("too many"), "{}", outcome.stderr);
}

/// A limit on the size of a file stands in for a full disk: the write fails in the midst, on any
/// machine.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_index_and_no_debris() {
    let folder = tempfile::tempdir().unwrap();
    let index = folder.path().join("grasp.idx");
    fs::copy(small_index(), &index).unwrap();
    let before = fs::read(&index).unwrap();
    let builder = program("grasp-builder").get_program().to_owned();
    let outcome = run(std::process::Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" build --step 45 --out \"$1\""])
        .arg(builder)
        .arg(&index));
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("grasp.idx"), "{}", outcome.stderr);
    assert!(fs::read(&index).unwrap() == before);
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(
        left.iter().all(|name| name == "grasp.idx" || name.to_string_lossy().ends_with(".lock")),
        "{left:?}"
    );
}

#[test]
fn standard_output_is_no_file() {
    let labels = pictures().join("labels.csv").display().to_string();
    for (name, arguments) in [
        ("grasp-query", &["evaluate", &labels, "--predictions", "-"][..]),
        ("grasp-query", &["experiment", "report", &labels, "--out", "-"]),
        ("grasp-builder", &["build", "--out", "-"]),
        ("grasp-builder", &["export", "grasp.idx", "--labels", "-"]),
        ("grasp-builder", &["queries", "--out", "-"]),
    ] {
        let outcome = run(program(name).args(arguments));
        assert_eq!(outcome.status, 2, "{arguments:?}");
        assert!(outcome.stderr.contains("this cannot go to standard output"), "{}", outcome.stderr);
    }
}

#[test]
fn an_empty_folder_takes_nothing_from_the_others() {
    let empty = tempfile::tempdir().unwrap();
    let outcome = run(program("grasp-query")
        .args(["recognise", "--json", "--segmented", "--index"])
        .arg(small_index())
        .arg(empty.path())
        .arg(good()));
    let records = outcome.json_lines();
    assert_eq!((outcome.status, records.len()), (2, 2), "{}", outcome.stderr);
    assert_eq!(records[0]["error"]["kind"], "unreadable", "{}", records[0]);
    assert!(records[1]["grasp"].is_string(), "{}", records[1]);
}
