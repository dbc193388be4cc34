//! From a picture to a record, over a small index made here.

use std::io::Cursor;

use grasp_answer::{human, record::Record};
use grasp_index::{
    ClassInfo, DescriptorParams, HandImage, Index, IndexParams, IndexWriter, NewEntry, mirror_orientation,
};
use grasp_query::evaluate::{self, labels, report};
use grasp_recognise::segment::{Finder, Mask, SegmentParams};
use grasp_recognise::{HandChoice, MaskSource, RecogniseOptions, Recogniser, Side};
use image::{ImageFormat, Rgb, RgbImage};
use nalgebra::{UnitQuaternion, Vector3};

const SIDE: u32 = 64;

/// A "hand" of one of two kinds: a palm with one long finger, or with two short ones. `n` varies it
/// a little.
fn grey_of(class: u16, n: u32) -> Vec<u8> {
    let mut grey = vec![0; (SIDE * SIDE) as usize];
    for y in 0..SIDE {
        for x in 0..SIDE {
            let palm = (14..44).contains(&x) && (30..54 + n % 3).contains(&y);
            let finger = match class {
                0 => (16..24).contains(&x) && (4 + n % 4..30).contains(&y),
                _ => ((14..20).contains(&x) || (34..46).contains(&x)) && (20 - n % 4..30).contains(&y),
            };
            if palm || finger {
                grey[(y * SIDE + x) as usize] = (80 + x + (y * 3) % 40) as u8;
            }
        }
    }
    grey
}

fn orientation(n: u32) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(0.2, -0.4, 0.1 + 0.01 * f64::from(n))
}

fn index() -> Index {
    let class = |name: &str, cutkosky| ClassInfo { name: name.into(), cutkosky };
    let params = DescriptorParams::default();
    let mut writer = IndexWriter::new(IndexParams {
        descriptor: params,
        classes: vec![class("pinch", 9), class("power-sphere", 10)],
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        thumbnail_side: 16,
        ..IndexParams::default()
    })
    .unwrap();
    for n in 0..40u32 {
        let class = (n % 2) as u16;
        let hand = HandImage::from_segmented(SIDE as usize, SIDE as usize, &grey_of(class, n), 0).unwrap();
        let entry = NewEntry {
            class,
            file: format!("{n}.png"),
            object: "ball".into(),
            azimuth_deg: n as f32,
            orientation: orientation(n),
            descriptor: params.describe(&hand).expect("the parameters are in range"),
            thumbnail: Some(hand.thumbnail(16)),
            ..NewEntry::default()
        };
        writer.push(entry).unwrap();
    }
    Index::from_bytes(&writer.finish_bytes().unwrap()).unwrap()
}

fn png(image: RgbImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).unwrap();
    bytes
}

fn segmented(class: u16, n: u32) -> RgbImage {
    let grey = grey_of(class, n);
    RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb([grey[(y * SIDE + x) as usize]; 3]))
}

/// The same hand in the colour of skin before a blue wall.
fn camera(class: u16, n: u32) -> RgbImage {
    let mut image = segmented(class, n);
    for pixel in image.pixels_mut() {
        let shade = i32::from(pixel[0]) - 128;
        *pixel = if pixel[0] == 0 {
            Rgb([60, 90, 150])
        } else {
            Rgb([205, 150, 120].map(|value: i32| (value + shade / 3) as u8))
        };
    }
    image
}

fn recogniser(index: &Index, hand: HandChoice, rolls: usize) -> Recogniser<'_> {
    // These pictures have the colours of hands, and shapes that no hand has.
    let segment = SegmentParams { by: Finder::Skin, ..SegmentParams::default() };
    Recogniser::new(index, RecogniseOptions { hand, rolls, segment, ..RecogniseOptions::default() })
}

#[test]
fn a_segmented_picture_is_recognised_with_its_orientation() {
    let index = index();
    let found = recogniser(&index, HandChoice::Right, 1)
        .recognise(&png(segmented(1, 7)), &MaskSource::Segmented)
        .unwrap();
    assert_eq!(found.best.vote.classes[0].name, "power-sphere");
    assert!(found.best.neighbours[0].distance < 1e-3);
    assert!(found.best.vote.orientation.rotation.angle_to(&orientation(20)) < 0.3);
}

#[test]
fn a_turned_picture_is_turned_back() {
    let index = index();
    let upright = segmented(0, 6);
    let turned = image::imageops::rotate90(&upright);
    let level = recogniser(&index, HandChoice::Right, 4);
    let upright = level.recognise(&png(upright), &MaskSource::Segmented).unwrap();
    let found = level.recognise(&png(turned), &MaskSource::Segmented).unwrap();
    assert_eq!(upright.best.roll_deg, 0.0);
    assert_eq!(found.best.roll_deg, 270.0, "turned clockwise by 90, so by 270 more to be level");
    assert_eq!(found.best.vote.classes[0].name, "pinch");
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    let expected = quarter * upright.best.vote.orientation.rotation;
    assert!(found.best.vote.orientation.rotation.angle_to(&expected) < 0.02);
}

#[test]
fn a_mirrored_picture_shows_the_other_hand() {
    let index = index();
    let free = recogniser(&index, HandChoice::Auto, 1);
    let right = free.recognise(&png(segmented(0, 6)), &MaskSource::Segmented).unwrap();
    let mirrored = image::imageops::flip_horizontal(&segmented(0, 6));
    let left = free.recognise(&png(mirrored), &MaskSource::Segmented).unwrap();
    assert_eq!((right.best.side, left.best.side), (Side::Right, Side::Left));
    assert_eq!(right.best.neighbours, left.best.neighbours);
    let expected = mirror_orientation(&right.best.vote.orientation.rotation);
    assert!(left.best.vote.orientation.rotation.angle_to(&expected) < 1e-6);
}

#[test]
fn a_camera_picture_is_segmented_by_the_colour_of_skin() {
    let index = index();
    let found =
        recogniser(&index, HandChoice::Right, 1).recognise(&png(camera(1, 9)), &MaskSource::Camera).unwrap();
    let truth = Mask::from_values(SIDE as usize, SIDE as usize, &grey_of(1, 9), |value| value > 0);
    assert!(truth.iou(&found.prepared.mask).unwrap() > 0.8);
    assert_eq!(found.best.vote.classes[0].name, "power-sphere");
}

#[test]
fn a_given_mask_replaces_the_segmentation_and_must_fit() {
    let index = index();
    let recogniser = recogniser(&index, HandChoice::Right, 1);
    let picture = png(camera(0, 4));
    let truth = Mask::from_values(SIDE as usize, SIDE as usize, &grey_of(0, 4), |value| value > 0);
    let found = recogniser.recognise(&picture, &MaskSource::Given(truth.clone())).unwrap();
    assert_eq!(found.prepared.mask, truth);
    let other = MaskSource::Given(Mask::from_grey(3, 3, &[255; 9]));
    let error = recogniser.recognise(&picture, &other).unwrap_err();
    assert!(error.to_string().contains("3 x 3") && !error.is_rejection(), "{error}");
}

#[test]
fn depth_tells_the_hand_from_the_wall() {
    let index = index();
    let depth: Vec<u16> = grey_of(0, 4).iter().map(|&grey| if grey > 0 { 600 } else { 1800 }).collect();
    let source = MaskSource::Depth {
        width: SIDE as usize,
        height: SIDE as usize,
        depth,
        range: "400..900".parse().unwrap(),
    };
    let wall = RgbImage::from_pixel(SIDE, SIDE, Rgb([90; 3]));
    let found = recogniser(&index, HandChoice::Right, 1).recognise(&png(wall), &source).unwrap();
    let truth = Mask::from_values(SIDE as usize, SIDE as usize, &grey_of(0, 4), |value| value > 0);
    assert!(truth.iou(&found.prepared.mask).unwrap() > 0.95);
}

#[test]
fn a_picture_without_a_hand_is_rejected() {
    let index = index();
    let recogniser = recogniser(&index, HandChoice::Auto, 2);
    let blue = png(RgbImage::from_pixel(80, 60, Rgb([40, 70, 160])));
    let black = png(RgbImage::new(80, 60));
    let empty = MaskSource::Given(Mask::from_grey(80, 60, &[127; 80 * 60]));
    for (picture, source, says) in [
        (&blue, MaskSource::Camera, "no hand found: nothing in the picture looks like one"),
        (&black, MaskSource::Camera, "no hand found: nothing in the picture looks like one"),
        (&black, MaskSource::Segmented, "no hand: the picture is all black"),
        (&blue, empty, "no hand: the mask is empty: values of 128 to 255 are the hand"),
    ] {
        let error = recogniser.recognise(picture, &source).unwrap_err();
        let record = Record::not_recognised("wall.png".into(), None, &error);
        assert_eq!((error.kind(), record.status()), ("no_hand", 1));
        let text = human::text(&record);
        assert!(text.starts_with(&format!("wall.png: {says}")), "{text}");
    }
}

#[test]
fn records_keep_their_keys() {
    let index = index();
    let recogniser = Recogniser::new(
        &index,
        RecogniseOptions { hand: HandChoice::Auto, rolls: 2, k: Some(2), ..RecogniseOptions::default() },
    );
    let found = recogniser.recognise(&png(segmented(0, 6)), &MaskSource::Segmented).unwrap();
    let record = Record::answer("a/hand.png".into(), Some(3), &found, &index, true).unwrap();
    let settings = || {
        let mut settings = insta::Settings::clone_current();
        // Digits behind the third differ with the machine's mathematics.
        settings.add_filter(r"(\d+\.\d{3})\d+(e-\d+)?", "$1");
        settings.add_filter(r"-?\d+\.\d+e-\d+", "[tiny]");
        settings.add_filter(r#"("\w+_ms": )[^,\n]+"#, "$1[time]");
        // How the tables are sized is the index's own business.
        settings.add_filter(r#"("(tables|buckets|candidates|share_of_database)": )[^,\n]+"#, "$1[cost]");
        settings
    };
    settings().bind(|| {
        insta::assert_snapshot!("answer", serde_json::to_string_pretty(&record).unwrap());
        let error = recogniser.recognise(b"nothing", &MaskSource::Camera).unwrap_err();
        let failure = Record::not_recognised("a/nothing.png".into(), None, &error);
        insta::assert_snapshot!("failure", serde_json::to_string_pretty(&failure).unwrap());
    });
    assert_eq!(record.status(), 0);
}

#[test]
fn an_evaluation_counts_what_is_right_what_is_wrong_and_what_is_broken() {
    let index = index();
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, image: RgbImage| image.save(folder.path().join(name)).unwrap();
    save("right.png", segmented(0, 6));
    save("wrong.png", segmented(1, 7));
    save("wall.png", RgbImage::from_pixel(80, 60, Rgb([40, 70, 160])));
    save("camera.png", camera(1, 9));
    save("mask.png", {
        let mut mask = segmented(1, 9);
        mask.pixels_mut().filter(|pixel| pixel[0] > 0).for_each(|pixel| *pixel = Rgb([255; 3]));
        mask
    });
    let q = orientation(20);
    let table = format!(
        "file,mask,kind,grasp,stage,hand,qx,qy,qz,qw,group\n\
         right.png,,segmented,pinch,grasp,right,{},{},{},{},a\n\
         wrong.png,,segmented,pinch,reach,right,,,,,a\n\
         wall.png,,camera,pinch,grasp,,,,,,b\n\
         camera.png,mask.png,camera,power-sphere,grasp,,,,,,b\n\
         wrong.png,,segmented,other,grasp,,,,,,b\n\
         missing.png,,camera,pinch,grasp,,,,,,b\n\
         right.png,,photograph,pinch,grasp,,,,,,b\n",
        q.i, q.j, q.k, q.w
    );
    let path = folder.path().join("labels.csv");
    std::fs::write(&path, table).unwrap();

    let recogniser = recogniser(&index, HandChoice::Right, 1);
    let (mut broken, mut outcomes) = (Vec::new(), Vec::new());
    for row in labels::read(&path).unwrap() {
        match row {
            Ok(label) => outcomes.push(evaluate::score(&recogniser, folder.path(), label, false)),
            Err(error) => broken.push(error),
        }
    }
    let classes = vec!["pinch".into(), "power-sphere".into()];
    let report = report::Report::new(classes, &outcomes, &broken, false);
    assert_eq!((report.n, report.top1, report.unknown, report.other.n), (4, 0.5, 1, 1));
    assert_eq!(report.confusion.counts, [[1, 1, 1], [0, 1, 0]]);
    assert_eq!((report.per_stage["grasp"].n, report.per_stage["reach"].right), (3, 0));
    assert_eq!(report.orientation_error_deg.n, 1);
    assert!(report.orientation_error_deg.mean.unwrap() < 15.0);
    let segmentation = report.segmentation.unwrap();
    assert!(segmentation.n == 1 && segmentation.mean_iou_hand > 0.8, "{segmentation:?}");
    let lines: Vec<u64> = report.errors.iter().map(|error| error.line).collect();
    assert_eq!(lines, [8, 7], "the broken row first, then the missing picture");
    assert!(report::text(&report).contains("top-1 50.0 % of 4 pictures"));
}

#[test]
fn an_explanation_is_drawn_for_every_answer() {
    let index = index();
    let found =
        recogniser(&index, HandChoice::Auto, 3).recognise(&png(camera(1, 9)), &MaskSource::Camera).unwrap();
    let Record::Answer(answer) = Record::answer("hand.png".into(), None, &found, &index, false).unwrap()
    else {
        panic!("an answer is no failure")
    };
    let drawing = grasp_answer::explain::draw(&found, &answer, &index);
    let colours: std::collections::HashSet<[u8; 3]> = drawing.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 100, "only {} colours", colours.len());
}
