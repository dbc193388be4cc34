//! Streams of pictures, however the pipe cuts them and whatever lies between them.

use std::io::{Cursor, Read};

use grasp_picture::{DecodeError, Frame, Frames, StreamError, decode};
use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use proptest::prelude::*;

/// A picture without symmetry.
fn picture(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| Rgb([(x * 7) as u8, (y * 11) as u8, (x * y) as u8]))
}

fn encoded(image: RgbImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    DynamicImage::from(image).write_to(&mut Cursor::new(&mut bytes), format).unwrap();
    bytes
}

fn jpeg(width: u32, height: u32) -> Vec<u8> {
    encoded(picture(width, height), ImageFormat::Jpeg)
}

/// A pipe that gives a few bytes at a time.
struct Drip<'a> {
    bytes: &'a [u8],
    at_once: usize,
}

impl Read for Drip<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let given = self.at_once.min(buffer.len()).min(self.bytes.len());
        buffer[..given].copy_from_slice(&self.bytes[..given]);
        self.bytes = &self.bytes[given..];
        Ok(given)
    }
}

/// The frames of a stream, and how many bytes were skipped before each and behind the last.
fn split(bytes: &[u8], at_once: usize) -> (Vec<Vec<u8>>, Vec<u64>) {
    let mut frames = Frames::new(Drip { bytes, at_once });
    let found: Vec<Frame> = frames.by_ref().map(Result::unwrap).collect();
    let skipped = found.iter().map(|frame| frame.skipped).chain([frames.skipped_at_end()]).collect();
    (found.into_iter().map(|frame| frame.bytes).collect(), skipped)
}

/// Asserts what a stream is split into, in whatever pieces it comes.
fn assert_split(stream: &[u8], frames: &[Vec<u8>], skipped: &[u64]) {
    for at_once in (1..stream.len() + 2).step_by(if stream.len() > 1500 { 13 } else { 1 }) {
        let found = split(stream, at_once);
        assert_eq!(found.1, skipped, "{at_once} bytes at a time");
        assert!(found.0 == frames, "{at_once} bytes at a time");
    }
}

#[test]
fn a_stream_is_split_where_its_frames_end_however_the_pipe_cuts_it() {
    let pnm = |w, h| encoded(picture(w, h), ImageFormat::Pnm);
    let png = |w, h| encoded(picture(w, h), ImageFormat::Png);
    let bmp = |w, h| encoded(picture(w, h), ImageFormat::Bmp);
    let grey = b"P5 # a comment\n# and another\n4 3\n255\n0123456789AB".to_vec();
    let colour = [b"P6 2 1 255\n".as_slice(), &[1, 2, 3, 4, 5, 6]].concat();
    let wide = b"P5\n2 2\n65535\n01234567".to_vec();
    let bits = b"P4\n9 2\nabcd".to_vec();
    for frames in [
        vec![pnm(5, 4), pnm(5, 4), pnm(7, 2)],
        vec![jpeg(9, 9), jpeg(16, 8), jpeg(24, 24)],
        vec![png(9, 9), png(16, 8), png(3, 3)],
        vec![bmp(5, 3), bmp(2, 2)],
        vec![grey, pnm(3, 3), colour, wide, bits, jpeg(8, 8), png(4, 4), pnm(1, 1)],
    ] {
        assert_split(&frames.concat(), &frames, &vec![0; frames.len() + 1]);
    }
}

#[test]
fn restart_markers_and_stuffed_bytes_do_not_end_a_jpeg() {
    let frame = [
        &[0xFF, 0xD8, 0xFF, 0xE0, 0, 4, 0xFF, 0xD9][..], // an end marker inside a segment
        &[0xFF, 0xDA, 0, 2, 1, 2, 0xFF, 0x00, 3, 0xFF, 0xD0, 4, 0xFF, 0xFF, 0xD9],
    ]
    .concat();
    assert_split(&frame.repeat(3), &[frame.clone(), frame.clone(), frame], &[0; 4]);
}

#[test]
fn what_belongs_to_no_frame_is_skipped_up_to_the_next_of_the_kind() {
    let (a, b) = (jpeg(9, 9), jpeg(16, 8));
    // What begins like a marker, like another format or like a boundary is none.
    let garbage = b"\xFF\xFF\x00\xFF\xD9P6 -- 8bytes\xFF".as_slice();
    let stream = [&[0; 5], &a[..], &[0; 300], &b, garbage, &a, &[0xFF, 0xD8]].concat();
    assert_split(&stream, &[a.clone(), b, a], &[5, 300, garbage.len() as u64, 2]);
}

#[test]
fn parts_of_a_multipart_response_are_frames_whatever_their_headers_say() {
    let (a, b) = (jpeg(9, 9), jpeg(16, 8));
    let stream = [
        b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=x\r\n\r\n--x\r\n".as_slice(),
        b"Content-Type: image/jpeg\r\nContent-Length: 7\r\n\r\n",
        &a,
        b"\r\n--x\r\nContent-Type: image/jpeg\r\n\r\n",
        &b,
        b"--x\nContent-Type: image/jpeg\n\n",
        &a,
        b"\r\n--x--\r\n",
    ]
    .concat();
    assert_split(&stream, &[a.clone(), b, a], &[0; 4]);
}

#[test]
fn a_last_frame_cut_short_is_given_as_it_is_and_decoding_says_why() {
    let whole = encoded(picture(20, 20), ImageFormat::Pnm);
    let cut = &whole[..whole.len() - 1];
    let (found, _) = split(&[&whole[..], cut].concat(), 100);
    assert_eq!(found, [&whole[..], cut]);
    assert!(decode(&found[0]).is_ok());
    assert!(matches!(decode(&found[1]), Err(DecodeError::Truncated)));
}

#[test]
fn a_jpeg_cut_short_does_not_swallow_the_next_one() {
    let whole = jpeg(64, 64);
    let cut = whole[..whole.len() / 2].to_vec();
    let stream = [&whole[..], &cut, &whole[..]].concat();
    assert_split(&stream, &[whole.clone(), cut.clone(), whole], &[0; 4]);
    assert!(matches!(decode(&cut), Err(DecodeError::Truncated)));
}

/// A pipe that breaks when more is asked for than has come.
struct Live<'a>(&'a [u8]);

impl Read for Live<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        assert!(!self.0.is_empty(), "more is asked for before the frame is given");
        self.0.read(buffer)
    }
}

#[test]
fn a_frame_is_given_when_its_last_byte_has_come() {
    let y4m = b"YUV4MPEG2 W2 H2 Cmono\nFRAME\n\x10\x10\xEB\xEB";
    let part = [b"--x\r\n\r\n", &jpeg(9, 9)[..]].concat();
    for stream in [&jpeg(9, 9)[..], &part, &encoded(picture(9, 9), ImageFormat::Pnm), y4m] {
        assert!(Frames::new(Live(stream)).next().unwrap().is_ok());
    }
}

#[test]
fn zeros_before_raw_video_are_skipped() {
    let (frames, skipped) = split(b"\0\0\0YUV4MPEG2 W1 H1 Cmono\nFRAME\n\x10", 2);
    assert_eq!((frames, skipped), (vec![b"P5\n1 1\n255\n\0".to_vec()], vec![3, 0]));
}

#[test]
fn a_gigantic_frame_ends_the_stream_with_an_error() {
    for header in ["P6\n30000 30000\n255\n", "YUV4MPEG2 W30000 H30000\n"] {
        let mut frames = Frames::new(Cursor::new(header));
        assert!(matches!(frames.next(), Some(Err(StreamError::TooLarge))));
        assert!(frames.next().is_none());
    }
}

#[test]
fn raw_video_becomes_pictures_of_its_colours() {
    let rgb = |stream: &[u8]| {
        let (frames, skipped) = split(stream, 7);
        assert!(skipped.iter().all(|&skipped| skipped == 0));
        let decoded = frames.iter().map(|frame| decode(frame).unwrap().image.into_rgb8());
        decoded.map(|image| image.pixels().map(|pixel| pixel.0).collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    let (black, white, red) = ([0; 3], [255; 3], [254, 0, 0]);
    // Three columns and rows: the colour of the last is its own.
    let luma = [16, 16, 235, 16, 16, 235, 81, 81, 81];
    let half = [
        b"YUV4MPEG2 W3 H3 F30:1 Ip A1:1 C420jpeg\nFRAME\n".as_slice(),
        &luma,
        &[128, 128, 90, 90],
        &[128, 128, 240, 240],
    ]
    .concat();
    let first = vec![black, black, white, black, black, white, red, red, red];
    assert_eq!(rgb(&half), std::slice::from_ref(&first));
    let twice = [&half[..], b"FRAME Ip\n", &luma, &[128, 128, 90, 90], &[128, 128, 240, 240]].concat();
    assert_eq!(rgb(&twice), [first.clone(), first.clone()]);
    let beside =
        [b"YUV4MPEG2 W2 H2 C422\nFRAME\n".as_slice(), &[16, 235, 81, 81], &[128, 90], &[128, 240]].concat();
    assert_eq!(rgb(&beside), [[black, white, red, red]]);
    let full = [b"YUV4MPEG2 W2 H1 C444 XCOLORRANGE=FULL\nFRAME\n".as_slice(), &[0, 255, 128, 128, 128, 128]]
        .concat();
    assert_eq!(rgb(&full), [[black, white]]);
    assert_eq!(rgb(b"YUV4MPEG2 W1 H2 Cmono\nFRAME\n\x10\xEB"), [[black, white]]);
    let behind = [&half[..], b"YUV4MPEG2 W1 H2 Cmono\nFRAME\n\x10\xEB"].concat();
    assert_eq!(rgb(&behind), [first, vec![black, white]]);
    for header in ["W2 H2 C420p10", "W2", "W-1 H2", "Cmono H1 W"] {
        let stream = format!("YUV4MPEG2 {header}\nFRAME\n1234567890");
        let error = Frames::new(Cursor::new(stream)).next().unwrap().unwrap_err();
        assert!(matches!(error, StreamError::Y4m(_)), "{header}: {error}");
    }
}

proptest! {
    /// What is given and what is skipped lies in the stream in its order.
    #[test]
    fn no_byte_is_given_twice(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        head in 0..7usize,
        at_once in 1..40usize,
    ) {
        let png = b"\x89PNG\r\n\x1a\n\0\0\0\x03IHDR";
        let heads: [&[u8]; 7] =
            [b"", b"P6\n2 2\n255\n", b"P4 8", &[0xFF, 0xD8, 0xFF], png, b"--x\r\n", b"RIFF\x0C\0\0\0WEBP"];
        let bytes = [heads[head], &bytes[..]].concat();
        let mut rest = &bytes[..];
        let mut frames = Frames::new(Drip { bytes: &bytes, at_once });
        for frame in frames.by_ref().map_while(Result::ok) {
            prop_assert!(!frame.bytes.is_empty());
            let at = rest.windows(frame.bytes.len()).position(|window| window == frame.bytes);
            let at = at.expect("a frame is of the stream");
            prop_assert!(frame.skipped as usize <= bytes.len());
            rest = &rest[at + frame.bytes.len()..];
        }
        prop_assert!(frames.skipped_at_end() as usize <= bytes.len());
    }
}
