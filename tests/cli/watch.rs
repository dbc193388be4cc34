//! `grasp-query watch`: answers drawn into the frames of a video, and cameras.

use std::fs;
use std::io::{BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::Stdio;

use grasp_picture::Frames;
use grasp_tests::{Outcome, pictures, program, run, run_with_input, small_index, workspace};
use image::RgbImage;
use serde_json::Value;

fn jpeg(name: &str) -> Vec<u8> {
    fs::read(pictures().join(format!("camera/{name}.jpg"))).unwrap()
}

/// The arguments for a source, by the small index.
fn watch(folder: &Path, arguments: &[&str]) -> std::process::Command {
    let mut command = program("grasp-query");
    command.arg("watch").args(arguments).arg("--index").arg(small_index()).current_dir(folder);
    command
}

/// The frames of a video that was written.
fn frames(path: &Path) -> Vec<RgbImage> {
    let frames = Frames::new(BufReader::new(fs::File::open(path).unwrap()));
    frames.map(|frame| image::load_from_memory(&frame.unwrap().bytes).unwrap().to_rgb8()).collect()
}

fn json_lines(path: &Path) -> Vec<Value> {
    fs::read_to_string(path).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// How many pixels of a picture have about this colour.
fn count(picture: &RgbImage, colour: [u8; 3]) -> usize {
    let is_near = |pixel: &&image::Rgb<u8>| pixel.0.iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 40);
    picture.pixels().filter(is_near).count()
}

/// The colours of the hand's outline and of a robot's approach.
const OUTLINE: [u8; 3] = [110, 210, 130];
const ROBOT: [u8; 3] = [235, 120, 220];

/// A video: a hand, none, a hand, and a frame that is cut short.
fn video() -> Vec<u8> {
    let (hand, none) = (jpeg("01-large-diameter"), jpeg("no-hand"));
    [hand.as_slice(), &none, &hand, &hand[..hand.len() / 3]].concat()
}

#[test]
fn frames_in_are_frames_out_each_with_its_answer() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("in.mjpg"), video()).unwrap();
    let arguments = ["in.mjpg", "--out", "out.mjpg", "--json=out.jsonl", "--timings", "--accept", "always"];
    let outcome = run(&mut watch(folder.path(), &arguments));
    assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{}", outcome.stderr);
    for said in ["4 frames; a frame takes ", "recognise", "the hand was looked for in the whole picture "] {
        assert!(outcome.stderr.contains(said), "no `{said}` in {}", outcome.stderr);
    }

    let records = json_lines(&folder.path().join("out.jsonl"));
    let numbers: Vec<_> = records.iter().map(|record| record["frame"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [0, 1, 2, 3]);
    assert_eq!(records[1]["error"]["kind"], "no_hand");
    assert_eq!(records[3]["error"]["kind"], "truncated");
    assert_eq!(records[0]["file"], "in.mjpg");
    assert!(records[0]["single"].is_object() && records[0]["timings"]["decode_ms"].as_f64().unwrap() > 0.0);

    let frames = frames(&folder.path().join("out.mjpg"));
    let sizes: Vec<_> = frames.iter().map(RgbImage::dimensions).collect();
    assert_eq!(sizes, [(640, 636); 4], "the strip is below the frame");
    let outlined: Vec<bool> = frames.iter().map(|frame| count(frame, OUTLINE) > 400).collect();
    assert_eq!(outlined, [true, false, true, false]);

    // The first frame of a video is answered as the picture alone.
    let alone = run(program("grasp-query")
        .args(["recognise", "--json", "--accept", "always", "--index"])
        .arg(small_index())
        .arg(pictures().join("camera/01-large-diameter.jpg")));
    assert_eq!(alone.json_lines()[0]["classes"], records[0]["classes"]);
}

#[test]
fn a_video_goes_from_pipe_to_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = watch(folder.path(), &["-", "--out", "-", "--json=records.jsonl"]);
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut out = Frames::new(child.stdout.take().unwrap());
    // Each frame comes out before the next goes in.
    for _ in 0..3 {
        stdin.write_all(&jpeg("10-power-sphere")).unwrap();
        stdin.flush().unwrap();
        let drawn = out.next().unwrap().unwrap();
        assert!(image::load_from_memory(&drawn.bytes).is_ok());
    }
    drop(stdin);
    assert!(out.next().is_none());
    assert!(child.wait().unwrap().code().is_some_and(|code| code < 2));
    assert_eq!(json_lines(&folder.path().join("records.jsonl")).len(), 3);
}

#[test]
fn of_a_live_source_old_frames_are_dropped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let many: Vec<u8> = (0..60).flat_map(|_| jpeg("01-large-diameter")).collect();
    let outcome = run_with_input(
        &mut watch(folder.path(), &["-", "--live", "--out", "out.mjpg", "--json=out.jsonl"]),
        &many,
    );
    let records = json_lines(&folder.path().join("out.jsonl"));
    let dropped = 60 - records.len();
    assert!(dropped > 0, "{}", outcome.stderr);
    let said = format!("{dropped} frames came faster than they were drawn, and were dropped");
    assert!(outcome.stderr.contains(&said), "{dropped}: {}", outcome.stderr);
    let numbers: Vec<u64> = records.iter().map(|record| record["frame"].as_u64().unwrap()).collect();
    assert!(numbers.is_sorted() && numbers.last() == Some(&59), "{numbers:?}");
    assert_eq!(frames(&folder.path().join("out.mjpg")).len(), records.len());
}

#[test]
fn the_robots_approach_is_drawn_where_there_is_a_strategy() {
    let folder = tempfile::tempdir().unwrap();
    let [object, camera] = ["bottle", "camera"]
        .map(|name| workspace().join(format!("query/data/objects/{name}.toml")).display().to_string());
    let picture = pictures().join("camera/01-large-diameter.jpg").display().to_string();
    let robot = ["--robot", "barrett", "--object", &object, "--camera", &camera, "--accept", "always"];
    let with =
        run(&mut watch(folder.path(), &[&[&*picture, "--out", "with.mjpg", "--json"][..], &robot].concat()));
    assert!(with.json_lines()[0]["strategy"]["approach_vector"].is_object(), "{}", with.stderr);
    run(&mut watch(folder.path(), &[&picture, "--out", "without.mjpg", "--accept", "always"]));
    let [with, without] =
        ["with", "without"].map(|name| count(&frames(&folder.path().join(format!("{name}.mjpg")))[0], ROBOT));
    assert!(with > without + 100, "{with} {without}");
}

#[test]
fn pictures_of_any_size_make_a_video_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |width, height| RgbImage::from_pixel(width, height, image::Rgb([90, 120, 100]));
    for (name, width, height) in [("1.png", 321, 241), ("2.png", 50, 200), ("3.png", 2000, 900)] {
        frame(width, height).save(folder.path().join(name)).unwrap();
    }
    let outcome = run(&mut watch(folder.path(), &[".", "--out", "out.mjpg"]));
    // A grasp, or why there is none, is told once for as long as it stays.
    assert_eq!(outcome.stdout.lines().count(), 1, "{}", outcome.stdout);
    assert!(outcome.stdout.contains("1.png frame 0: no hand found"), "{}", outcome.stdout);
    let sizes: Vec<_> = frames(&folder.path().join("out.mjpg")).iter().map(RgbImage::dimensions).collect();
    assert_eq!(sizes, [(400, 398); 3]);
    assert_eq!(outcome.status, 1);
}

fn told(outcome: &Outcome) -> &str {
    assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{}", outcome.stderr);
    outcome.stderr.trim_end()
}

#[test]
fn what_cannot_be_watched_is_told_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("clip.mp4"), b"\0\0\0\x20ftypisom").unwrap();
    fs::write(folder.path().join("in.mjpg"), jpeg("no-hand")).unwrap();
    fs::write(folder.path().join("empty.mjpg"), b"").unwrap();
    let refused = |arguments: &[&str]| {
        let outcome = run(&mut watch(folder.path(), arguments));
        told(&outcome).to_owned()
    };
    insta::assert_snapshot!(refused(&["in.mjpg", "--out", "-", "--json"]), @"grasp-query: frames and records cannot both go to -: name a file for one, as in --json=FILE");
    insta::assert_snapshot!(refused(&["in.mjpg", "--out", "in.mjpg"]), @"grasp-query: in.mjpg is an input as well: name another file to write");
    insta::assert_snapshot!(refused(&["empty.mjpg", "--out", "out.mjpg"]), @"grasp-query: empty.mjpg holds no frame: give pictures, or a stream of them");
    insta::assert_snapshot!(refused(&["in.mjpg", "--camera", "0", "--out", "out.mjpg"]), @"grasp-query: the frames are those of the camera /dev/video0: leave out SOURCE");
    insta::assert_snapshot!(refused(&["in.mjpg", "--camera", "c.toml", "--out", "out.mjpg"]), @"grasp-query: --camera c.toml is a description of where a camera stands, which --robot needs; a camera is named by its number, as in --camera 0, or by its device, as in --camera /dev/video0");
    insta::assert_snapshot!(refused(&["clip.mp4", "--out", "out.mjpg"]), @"grasp-query: clip.mp4 is a video in a container, which is not read: let ffmpeg read it, `ffmpeg -i clip.mp4 -f mjpeg -q:v 3 - | grasp-query watch - --out OUT.mjpg`");
    let missing = refused(&["in.mjpg", "none.mjpg", "--out", "out.mjpg"]);
    assert!(missing.starts_with("grasp-query: cannot read none.mjpg: "), "{missing}");
    assert!(!folder.path().join("out.mjpg").exists());
}

#[test]
fn without_a_frame_to_draw_on_an_older_video_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("notes.txt"), "no picture").unwrap();
    fs::write(path("keep.mjpg"), video()).unwrap();
    let outcome =
        run(&mut watch(folder.path(), &["notes.txt", "--out", "keep.mjpg", "--json=records.jsonl"]));
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(fs::read(path("keep.mjpg")).unwrap() == video(), "the video is another");
    assert!(
        outcome.stderr.contains("keep.mjpg: not written: there was no frame to draw on"),
        "{}",
        outcome.stderr
    );
    // Why, the records say.
    assert_eq!(json_lines(&path("records.jsonl"))[0]["error"]["kind"], "not_an_image");
    run(&mut watch(folder.path(), &["notes.txt", "--out", "new.mjpg"]));
    assert!(!path("new.mjpg").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_camera_that_is_not_there_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let missing = |arguments: &[&str]| {
        let outcome = run(program("grasp-query").args(arguments).arg("--index").arg(small_index()));
        told(&outcome).to_owned()
    };
    let recognise = missing(&["recognise", "--camera", "9999"]);
    assert!(recognise.starts_with("grasp-query: there is no camera /dev/video9999: "), "{recognise}");
    let out = folder.path().join("out.mjpg").display().to_string();
    assert_eq!(missing(&["watch", "--camera", "/dev/video9999", "--out", &out]), recognise);
    for by in [&["watch", "/dev/null", "--out", &out][..], &["recognise", "--camera", "/dev/null"]] {
        let no_camera = missing(by);
        assert!(
            no_camera.starts_with("grasp-query: /dev/null is no camera that gives pictures: "),
            "{no_camera}"
        );
    }
    let several = missing(&["recognise", "--camera", "0", "--camera", "1"]);
    assert_eq!(several, "grasp-query: --camera /dev/video0 and --camera /dev/video1: name one");
    let with_picture = missing(&["recognise", "--camera", "0", "x.png"]);
    assert!(with_picture.ends_with("leave out the pictures"), "{with_picture}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_was_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = watch(folder.path(), &["-", "--out", "out.mjpg", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(&jpeg("01-large-diameter")).unwrap();
    stdin.flush().unwrap();
    let mut out = child.stdout.take().unwrap();
    // The record has come, the pipe stays open.
    let mut first = [0];
    out.read_exact(&mut first).unwrap();
    let interrupted =
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupted.success());
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(frames(&folder.path().join("out.mjpg")).len(), 1);
    drop(stdin);
}
