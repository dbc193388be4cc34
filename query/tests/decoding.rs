//! Pictures as the world sends them: whole, cut short, forged, and one behind the other.

use std::io::{Cursor, Read};

use grasp_query::picture::{DecodeError, Frames, StreamError, decode, decode_grey, decode_grey16};
use image::{DynamicImage, ImageFormat, Luma, Rgb, RgbImage};
use proptest::prelude::*;

/// A picture without symmetry.
fn picture(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| Rgb([(x * 7) as u8, (y * 11) as u8, (x * y) as u8]))
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.into().write_to(&mut Cursor::new(&mut bytes), format).unwrap();
    bytes
}

const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Pnm];

#[test]
fn png_and_pnm_come_back_exactly_and_jpeg_nearly() {
    let original = picture(31, 17);
    for format in FORMATS {
        let decoded = decode(&encoded(original.clone(), format)).unwrap();
        assert_eq!((decoded.width(), decoded.height()), (31, 17));
        let farthest = decoded
            .rgb()
            .iter()
            .zip(original.pixels())
            .flat_map(|(a, b)| a.iter().zip(b.0).map(|(a, b)| a.abs_diff(b)))
            .max();
        let allowed = if format == ImageFormat::Jpeg { 120 } else { 0 };
        assert!(farthest.unwrap() <= allowed, "{format:?}: {farthest:?}");
    }
}

#[test]
fn a_picture_cut_short_is_truncated_in_every_format() {
    for format in FORMATS {
        let whole = encoded(picture(40, 30), format);
        let half = decode(&whole[..whole.len() / 2]).unwrap_err();
        assert!(matches!(half, DecodeError::Truncated), "half a {format:?}: {half}");
        // The last bytes of a PNG are an empty closing chunk: nothing is lost with them.
        let nearly = decode(&whole[..whole.len() - 2]);
        assert!(nearly.is_err() || format == ImageFormat::Png, "{format:?} without its last two bytes");
    }
}

#[test]
fn forged_headers_are_refused_before_anything_is_allocated() {
    for header in ["P6\n30000 30000\n255\n", "P5\n4000000000 4000000000\n255\n", "P4\n200000 200000\n"] {
        let error = decode(header.as_bytes()).unwrap_err();
        assert!(
            matches!(error, DecodeError::TooLarge { .. } | DecodeError::Damaged(_)),
            "{header:?}: {error}"
        );
    }
    let error = decode(b"P6\n30000 30000\n255\n").unwrap_err();
    assert!(error.to_string().contains("30000 x 30000"), "{error}");
    // A PNG whose header says 30,000 x 30,000; its checksum is right.
    let mut png = encoded(picture(2, 2), ImageFormat::Png);
    png[16..20].copy_from_slice(&30_000u32.to_be_bytes());
    png[20..24].copy_from_slice(&30_000u32.to_be_bytes());
    let checksum = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&checksum.to_be_bytes());
    assert!(matches!(decode(&png), Err(DecodeError::TooLarge { width: 30_000, height: 30_000 })));
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn what_is_no_image_says_so() {
    assert!(matches!(decode(b""), Err(DecodeError::Empty)));
    assert!(matches!(decode(b"not a picture at all"), Err(DecodeError::NotAnImage)));
    assert!(matches!(decode(b"P6\n0 5\n255\n"), Err(DecodeError::Damaged(_))));
}

#[test]
fn exif_orientation_is_obeyed() {
    let upright = encoded(picture(32, 16), ImageFormat::Jpeg);
    // An APP1 segment with one entry, orientation 6: the camera was held on its side.
    let mut exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0".to_vec();
    let mut turned = vec![0xFF, 0xD8, 0xFF, 0xE1];
    turned.extend(((exif.len() + 2) as u16).to_be_bytes());
    turned.append(&mut exif);
    turned.extend(&upright[2..]);
    let (upright, turned) = (decode(&upright).unwrap(), decode(&turned).unwrap());
    assert_eq!((turned.width(), turned.height()), (16, 32));
    assert_eq!(turned.rgb()[15], upright.rgb()[0], "the top left corner is now at the top right");
}

#[test]
fn masks_and_depth_are_read_as_what_they_are() {
    let mask = image::GrayImage::from_fn(3, 2, |x, _| Luma([if x == 1 { 255 } else { 0 }]));
    let (width, height, grey) = decode_grey(&encoded(mask, ImageFormat::Png)).unwrap();
    assert_eq!((width, height, grey), (3, 2, vec![0, 255, 0, 0, 255, 0]));

    let depth = image::ImageBuffer::<Luma<u16>, _>::from_fn(2, 1, |x, _| Luma([40_000 + x as u16]));
    let (_, _, values) = decode_grey16(&encoded(depth, ImageFormat::Png)).unwrap();
    assert_eq!(values, [40_000, 40_001]);
    let error = decode_grey16(&encoded(picture(2, 2), ImageFormat::Png)).unwrap_err();
    assert!(error.to_string().contains("16 bits"), "{error}");
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

#[test]
fn a_stream_is_split_where_its_frames_end_however_the_pipe_cuts_it() {
    let jpeg = |w, h| encoded(picture(w, h), ImageFormat::Jpeg);
    let pnm = |w, h| encoded(picture(w, h), ImageFormat::Pnm);
    let png = |w, h| encoded(picture(w, h), ImageFormat::Png);
    let grey = b"P5 # a comment\n# and another\n4 3\n255\n0123456789AB".to_vec();
    let colour = [b"P6 2 1 255\n".as_slice(), &[1, 2, 3, 4, 5, 6]].concat();
    let wide = b"P5\n2 2\n65535\n01234567".to_vec();
    let bits = b"P4\n9 2\nabcd".to_vec();
    for frames in [
        vec![pnm(5, 4), pnm(5, 4), pnm(7, 2)],
        vec![jpeg(9, 9), jpeg(16, 8), jpeg(24, 24)],
        vec![png(9, 9), png(16, 8), png(3, 3)],
        vec![grey, pnm(3, 3), colour, wide, bits, jpeg(8, 8), png(4, 4), pnm(1, 1)],
    ] {
        let stream = frames.concat();
        for at_once in (1..stream.len() + 2).step_by(if stream.len() > 1500 { 13 } else { 1 }) {
            let found: Vec<Vec<u8>> =
                Frames::new(Drip { bytes: &stream, at_once }).map(Result::unwrap).collect();
            assert_eq!(found, frames, "{at_once} bytes at a time");
        }
    }
}

#[test]
fn restart_markers_and_stuffed_bytes_do_not_end_a_jpeg() {
    let frame = [
        &[0xFF, 0xD8, 0xFF, 0xE0, 0, 4, 0xFF, 0xD9][..], // an end marker inside a segment
        &[0xFF, 0xDA, 0, 2, 1, 2, 0xFF, 0x00, 3, 0xFF, 0xD0, 4, 0xFF, 0xFF, 0xD9],
    ]
    .concat();
    let found: Vec<_> = Frames::new(Cursor::new(frame.repeat(3))).map(Result::unwrap).collect();
    assert_eq!(found, vec![frame.clone(), frame.clone(), frame]);
}

#[test]
fn a_last_frame_cut_short_is_given_as_it_is_and_decoding_says_why() {
    let whole = encoded(picture(20, 20), ImageFormat::Pnm);
    let stream = [&whole[..], &whole[..whole.len() - 1]].concat();
    let found: Vec<_> = Frames::new(Cursor::new(stream)).map(Result::unwrap).collect();
    assert_eq!(found.len(), 2);
    assert!(decode(&found[0]).is_ok());
    assert!(matches!(decode(&found[1]), Err(DecodeError::Truncated)));
}

#[test]
fn a_jpeg_cut_short_does_not_swallow_the_next_one() {
    let whole = encoded(picture(64, 64), ImageFormat::Jpeg);
    let stream = [&whole[..], &whole[..whole.len() - 40], &whole[..]].concat();
    let found: Vec<_> = Frames::new(Cursor::new(stream)).map(Result::unwrap).collect();
    assert_eq!(found.len(), 3);
    assert!(matches!(decode(&found[1]), Err(DecodeError::Truncated)));
    assert_eq!(found[2], whole);
}

#[test]
fn what_is_transparent_is_black() {
    let half =
        image::RgbaImage::from_fn(4, 2, |x, _| image::Rgba([200, 100, 50, if x < 2 { 255 } else { 0 }]));
    let picture = decode(&encoded(half, ImageFormat::Png)).unwrap();
    assert_eq!(picture.rgb()[1], [200, 100, 50]);
    assert_eq!(picture.rgb()[2], [0, 0, 0]);
}

#[test]
fn a_lone_picture_has_nothing_behind_it() {
    let png = encoded(picture(20, 20), ImageFormat::Png);
    let mut frames = Frames::new(Drip { bytes: &png, at_once: 10 });
    assert_eq!(frames.next().unwrap().unwrap(), png);
    assert!(!frames.has_more());
    assert!(frames.next().is_none());
}

#[test]
fn a_gigantic_frame_ends_the_stream_with_an_error() {
    let mut frames = Frames::new(Cursor::new(b"P6\n30000 30000\n255\n".to_vec()));
    assert!(matches!(frames.next(), Some(Err(StreamError::TooLarge))));
    assert!(frames.next().is_none());
}

proptest! {
    #[test]
    fn no_bytes_make_decoding_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), head in 0..5usize) {
        let heads: [&[u8]; 5] = [b"", b"P6 ", b"P5\n", &[0xFF, 0xD8, 0xFF], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"];
        let bytes = [heads[head], &bytes[..]].concat();
        let _ = decode(&bytes);
        let _ = decode_grey(&bytes);
        let _ = decode_grey16(&bytes);
    }

    #[test]
    fn no_damage_to_a_picture_makes_decoding_panic(
        format in 0..3usize,
        hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        keep in 0.0..1.0f64,
    ) {
        let mut bytes = encoded(picture(24, 18), FORMATS[format]);
        for (at, value) in hits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let _ = decode(&bytes);
        let _ = decode(&bytes[..(bytes.len() as f64 * keep) as usize]);
    }

    #[test]
    fn a_stream_loses_no_byte(bytes in prop::collection::vec(any::<u8>(), 0..300), head in 0..5usize, at_once in 1..40usize) {
        let png = b"\x89PNG\r\n\x1a\n\0\0\0\x03IHDR";
        let heads: [&[u8]; 5] = [b"", b"P6\n2 2\n255\n", b"P4 8", &[0xFF, 0xD8, 0xFF], png];
        let bytes = [heads[head], &bytes[..]].concat();
        let mut rebuilt = Vec::new();
        let mut failed = false;
        for frame in Frames::new(Drip { bytes: &bytes, at_once }) {
            match frame {
                Ok(frame) => {
                    prop_assert!(!frame.is_empty());
                    rebuilt.extend(frame);
                }
                Err(_) => failed = true,
            }
        }
        prop_assert!(bytes.starts_with(&rebuilt));
        prop_assert!(failed || rebuilt == bytes);
    }
}
