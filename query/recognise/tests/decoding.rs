//! Pictures as the world sends them: whole, cut short and forged.

use std::io::Cursor;

use grasp_recognise::picture::{self, DecodeError, DecodeWarning, Picture, decode_grey, decode_grey16};
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

fn decode(bytes: &[u8]) -> Result<Picture, DecodeError> {
    picture::decode(bytes).map(|decoded| decoded.picture)
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
        // Only PNM ends with pixels: nothing is lost with a closing chunk or an end marker.
        let nearly = decode(&whole[..whole.len() - 2]);
        assert_eq!(nearly.is_ok(), format != ImageFormat::Pnm, "{format:?} without its last two bytes");
    }
}

#[test]
fn a_jpeg_without_its_end_marker_is_told_from_one_that_is_cut() {
    let original = picture(256, 256);
    let whole = encoded(original.clone(), ImageFormat::Jpeg);
    assert!(picture::decode(&whole).unwrap().warnings.is_empty());
    let mut missing_before = 0;
    for cut in (whole.len() / 2..whole.len() - 1).rev().step_by(200) {
        match picture::decode(&whole[..cut]) {
            Ok(decoded) => match decoded.warnings[..] {
                [DecodeWarning::NoEndMarker { missing_percent }] => {
                    let bytes_missing = (100 * (whole.len() - cut)).div_ceil(whole.len()) as u32;
                    assert!(
                        missing_percent >= missing_before && missing_percent <= 25,
                        "{missing_percent} %"
                    );
                    assert!(
                        missing_percent.abs_diff(bytes_missing) < 10,
                        "{missing_percent} % of {bytes_missing}"
                    );
                    missing_before = missing_percent;
                }
                ref other => panic!("{cut} of {} bytes: {other:?}", whole.len()),
            },
            Err(error) => {
                assert!(matches!(error, DecodeError::Truncated), "{cut} of {} bytes: {error}", whole.len());
                assert!(missing_before > 15, "truncated where {missing_before} % were missing before");
            }
        }
    }
    assert!(matches!(decode(&whole[..whole.len() / 2]), Err(DecodeError::Truncated)));
    // A mask has nobody to warn.
    let mask = encoded(image::GrayImage::new(64, 64), ImageFormat::Jpeg);
    assert!(matches!(decode_grey(&mask[..mask.len() - 2]), Err(DecodeError::Truncated)));
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
    let white = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([255, 255, 255, 255 * x as u8]));
    let (_, _, grey) = decode_grey(&encoded(white, ImageFormat::Png)).unwrap();
    assert_eq!(grey, [0, 255], "what is transparent is outside");

    let depth = image::ImageBuffer::<Luma<u16>, _>::from_fn(2, 1, |x, _| Luma([40_000 + x as u16]));
    let (_, _, values) = decode_grey16(&encoded(depth, ImageFormat::Png)).unwrap();
    assert_eq!(values, [40_000, 40_001]);
    let error = decode_grey16(&encoded(picture(2, 2), ImageFormat::Png)).unwrap_err();
    assert!(error.to_string().ends_with("has 1 channel of 16 bits, this one 3 of 8"), "{error}");
}

#[test]
fn what_is_transparent_is_black() {
    let half =
        image::RgbaImage::from_fn(4, 2, |x, _| image::Rgba([200, 100, 50, if x < 2 { 255 } else { 0 }]));
    let picture = decode(&encoded(half, ImageFormat::Png)).unwrap();
    assert_eq!(picture.rgb()[1], [200, 100, 50]);
    assert_eq!(picture.rgb()[2], [0, 0, 0]);
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
}

/// A JPEG without the segments of this marker.
fn without(jpeg: &[u8], marker: u8) -> Vec<u8> {
    let mut kept = jpeg[..2].to_vec();
    let mut at = 2;
    while jpeg[at + 1] != 0xDA {
        let end = at + 2 + usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
        if jpeg[at + 1] != marker {
            kept.extend(&jpeg[at..end]);
        }
        at = end;
    }
    kept.extend(&jpeg[at..]);
    kept
}

#[test]
fn a_cameras_jpeg_without_huffman_tables_is_read_by_the_usual_ones() {
    // The encoder writes the usual tables, as cameras would.
    let whole = encoded(picture(64, 48), ImageFormat::Jpeg);
    let bare = without(&whole, 0xC4);
    assert!(bare.len() + 400 < whole.len(), "tables of 420 bytes are left out");
    assert_eq!(decode(&bare).unwrap(), decode(&whole).unwrap());
}
