//! Live streams, as cameras and cameras' programs send them.

use std::fs;
use std::io::{BufRead as _, BufReader, Cursor, Read as _, Write as _};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};

use grasp_tests::service::PATIENCE;
use grasp_tests::{Outcome, pictures, program, run_with_input, small_index};
use image::{DynamicImage, ImageFormat};
use serde_json::Value;

/// A photograph of a hand, as JPEG.
fn hand() -> Vec<u8> {
    fs::read(pictures().join("camera/01-large-diameter.jpg")).unwrap()
}

/// A photograph without a hand, as JPEG.
fn no_hand() -> Vec<u8> {
    fs::read(pictures().join("camera/no-hand.jpg")).unwrap()
}

fn command() -> Command {
    let mut command = program("grasp-query");
    command.args(["recognise", "--json", "--accept", "always", "-", "--index"]).arg(small_index());
    command
}

fn recognise(stream: &[u8]) -> Outcome {
    run_with_input(&mut command(), stream)
}

/// What became of each frame: its grasp, or the kind of its error.
fn told(outcome: &Outcome) -> Vec<String> {
    let of =
        |record: Value| record["grasp"].as_str().or(record["error"]["kind"].as_str()).unwrap().to_owned();
    outcome.json_lines().into_iter().map(of).collect()
}

/// The program, its pipe and its records as they come.
fn start() -> (std::process::Child, ChildStdin, Receiver<Value>) {
    let mut child =
        command().stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let stdin = child.stdin.take().unwrap();
    let stdout: ChildStdout = child.stdout.take().unwrap();
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            let _ = send.send(serde_json::from_str(&line).unwrap());
        }
    });
    (child, stdin, receive)
}

#[test]
fn each_frame_is_answered_when_its_last_byte_has_come() {
    let (mut child, mut stdin, records) = start();
    // The camera sends no second frame before the first is answered.
    for (number, frame) in [hand(), no_hand(), hand()].into_iter().enumerate() {
        stdin.write_all(&frame).unwrap();
        stdin.flush().unwrap();
        let record = records.recv_timeout(PATIENCE).expect("a frame is answered while the pipe is open");
        assert_eq!(record["frame"], number, "{record}");
    }
    drop(stdin);
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

#[test]
fn what_belongs_to_one_picture_is_not_taken_for_the_next() {
    let picture = fs::read(pictures().join("segmented/09-pinch.png")).unwrap();
    let mask = pictures().join("mask/09-pinch.png");
    let outcome = run_with_input(command().arg("--mask").arg(mask), &[&picture[..], &picture].concat());
    assert_eq!((outcome.status, outcome.stdout.lines().count()), (2, 1), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("are for a single picture, but - has more"), "{}", outcome.stderr);
}

#[test]
fn what_lies_between_frames_is_skipped_and_counted() {
    let garbage: Vec<u8> = (0..100_000u32).map(|at| (at * 7 % 251) as u8).collect();
    let zeros = vec![0; 1000];
    let alone = told(&recognise(&hand()));
    let stream = [&zeros[..], &hand(), &zeros, &no_hand(), &garbage, &hand(), b"the end"].concat();
    let outcome = recognise(&stream);
    assert_eq!(told(&outcome), [&alone[0], "no_hand", &alone[0]], "{}", outcome.stderr);
    // In the record, where there is one of an answer.
    let records = outcome.json_lines();
    for (record, said) in [
        (&records[0], "1000 bytes before this frame are no picture and were skipped"),
        (&records[2], "100000 bytes before this frame"),
    ] {
        let warning = &record["warnings"][0];
        assert_eq!(warning["kind"], "decoding", "{record}");
        assert!(warning["message"].as_str().unwrap().contains(said), "{record}");
    }
    for said in
        ["- frame 1: warning: 1000 bytes", "-: warning: 7 bytes behind the last frame are no whole picture"]
    {
        assert!(outcome.stderr.contains(said), "no `{said}` in {}", outcome.stderr);
    }
}

#[test]
fn a_jpeg_without_its_end_marker_is_answered_with_a_warning() {
    let whole = hand();
    let without_end = &whole[..whole.len() - 2];
    let stream = [without_end, &no_hand(), without_end].concat();
    let outcome = recognise(&stream);
    let alone = told(&recognise(&whole));
    assert_eq!(told(&outcome), [&alone[0], "no_hand", &alone[0]], "{}", outcome.stderr);
    assert_eq!(outcome.stdout.matches("the JPEG has no end marker").count(), 2, "{}", outcome.stdout);
    // Where most is missing there is nothing to answer.
    let outcome = recognise(&whole[..whole.len() / 3]);
    assert_eq!(told(&outcome), ["truncated"], "{}", outcome.stderr);
}

#[test]
fn the_parts_of_an_http_response_are_frames() {
    let part = |frame: &[u8], head: &str| [head.as_bytes(), b"\r\n\r\n", frame, b"\r\n"].concat();
    let plain = "--camera\r\nContent-Type: image/jpeg";
    let counted = format!("--camera\r\nContent-Type: image/jpeg\r\nContent-Length: {}", hand().len());
    let head = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=camera\r\n\r\n";
    let parts = [part(&hand(), &counted), part(&no_hand(), plain), part(&hand(), plain)].concat();
    let alone = told(&recognise(&hand()));
    for begins in [&b""[..], b"\r\n", head] {
        let outcome = recognise(&[begins, &parts, b"--camera--\r\n"].concat());
        assert_eq!(told(&outcome), [&alone[0], "no_hand", &alone[0]], "{}", outcome.stderr);
        assert!(!outcome.stderr.contains("warning"), "{}", outcome.stderr);
    }
}

/// A picture as a frame of YUV4MPEG2 in 4:4:4, by ITU-R BT.601.
fn y4m_frame(picture: &image::RgbImage) -> Vec<u8> {
    let plane = |of: fn([f32; 3]) -> f32| {
        picture.pixels().map(move |pixel| of(pixel.0.map(f32::from)).round() as u8).collect::<Vec<u8>>()
    };
    let luma = plane(|[r, g, b]| 16.0 + (65.481 * r + 128.553 * g + 24.966 * b) / 255.0);
    let blue = plane(|[r, g, b]| 128.0 + (-37.797 * r - 74.203 * g + 112.0 * b) / 255.0);
    let red = plane(|[r, g, b]| 128.0 + (112.0 * r - 93.786 * g - 18.214 * b) / 255.0);
    [b"FRAME\n".to_vec(), luma, blue, red].concat()
}

#[test]
fn raw_video_is_read() {
    let [hand, none] = [hand(), no_hand()].map(|jpeg| image::load_from_memory(&jpeg).unwrap().to_rgb8());
    let none = image::imageops::resize(&none, hand.width(), hand.height(), image::imageops::Triangle);
    let header = format!("YUV4MPEG2 W{} H{} F25:1 Ip C444\n", hand.width(), hand.height());
    let stream = [header.as_bytes(), &y4m_frame(&hand), &y4m_frame(&none), &y4m_frame(&hand)].concat();
    let outcome = recognise(&stream);
    let mut png = Vec::new();
    DynamicImage::from(hand).write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
    let alone = told(&recognise(&png));
    assert_eq!(told(&outcome), [&alone[0], "no_hand", &alone[0]], "{}", outcome.stderr);
    // A last frame that is cut short is told as that of encoded pictures is.
    for missing in [1, stream.len() / 4] {
        let outcome = recognise(&stream[..stream.len() - missing]);
        assert_eq!(told(&outcome), [&alone[0], "no_hand", "truncated"], "{}", outcome.stderr);
        assert_eq!((outcome.status, &outcome.json_lines()[2]["frame"]), (2, &2.into()));
    }
    let outcome = recognise(b"YUV4MPEG2 W64 H48 C420p10\nFRAME\n");
    assert!(outcome.stdout.contains("`C420p10` is not read; ask for 4:2:0"), "{}", outcome.stdout);
}

#[test]
fn other_formats_are_read_and_what_is_not_says_which_are() {
    let picture = image::load_from_memory(&hand()).unwrap().to_rgb8();
    let encoded = |format| {
        let mut bytes = Vec::new();
        DynamicImage::from(picture.clone()).write_to(&mut Cursor::new(&mut bytes), format).unwrap();
        bytes
    };
    let png = told(&recognise(&encoded(ImageFormat::Png)));
    for format in [ImageFormat::Bmp, ImageFormat::Pnm] {
        assert_eq!(told(&recognise(&encoded(format))), png, "{format:?}");
    }
    for (name, bytes) in [("TIFF", b"II*\0\x08\0\0\0".to_vec()), ("HEIC", b"\0\0\0\x18ftypheic".to_vec())] {
        let outcome = recognise(&bytes);
        let said = format!("{name} picture is not read; convert it to one of PNG, JPEG, WebP");
        assert!(outcome.stdout.contains(&said), "{}", outcome.stdout);
        assert_eq!((outcome.status, told(&outcome)), (2, vec!["unsupported_format".to_owned()]));
    }
}

#[test]
fn a_stream_that_ends_within_a_frame_ends() {
    let (mut child, mut stdin, records) = start();
    stdin.write_all(&hand()).unwrap();
    stdin.write_all(b"\r\n--camera\r\nContent-Ty").unwrap();
    drop(stdin);
    assert!(records.recv_timeout(PATIENCE).is_ok());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""));
}
