//! A hand made of balls, seen from many sides: pictures that vary as those of real hands do,
//! without a renderer.

#![allow(dead_code, reason = "every test and benchmark uses its own part")]

use grasp_index::{
    BuildError, ClassInfo, HandImage, HashParams, IndexParams, IndexWriter, NewEntry, RandomParams, Summary,
};
use nalgebra::{UnitQuaternion, Vector3};
use std::ops::ControlFlow;
use std::path::Path;

pub(crate) const SIDE: usize = 48;

/// The balls of a hand, centre and radius: a palm, four fingers and a thumb, bent by `curl` radians
/// a joint.
fn balls(curl: f64, spread: f64) -> Vec<(Vector3<f64>, f64)> {
    let mut balls = Vec::new();
    for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
        balls.push((Vector3::new(f64::from(x) * 0.22, f64::from(y) * 0.2 - 0.3, 0.0), 0.21));
    }
    let mut chain = |mut at: Vector3<f64>, mut direction: Vector3<f64>, axis: Vector3<f64>, joints: usize| {
        for joint in 0..joints {
            at += direction * 0.13;
            balls.push((at, 0.12));
            if joint % 2 == 1 {
                direction = UnitQuaternion::from_scaled_axis(axis * curl) * direction;
            }
        }
    };
    for finger in 0..4 {
        let side = f64::from(finger) - 1.5;
        let direction = Vector3::new(1.0, side * spread, 0.0).normalize();
        chain(Vector3::new(0.7, side * 0.2, 0.0), direction, Vector3::y(), 6);
    }
    chain(Vector3::new(0.1, 0.4, 0.0), Vector3::new(0.6, 0.8, 0.0), Vector3::new(-0.6, 0.6, 0.2), 4);
    balls
}

/// The ball hand of a class, as a camera sees it: `SIDE * SIDE` grey values.
pub(crate) fn picture(class: u16, shape: f64, camera_from_hand: &UnitQuaternion<f64>) -> Vec<u8> {
    let curl = 0.15 + 0.3 * f64::from(class % 3);
    let spread = if class < 3 { 0.05 } else { 0.3 };
    let mut grey = vec![0u8; SIDE * SIDE];
    let mut depth = vec![f64::INFINITY; SIDE * SIDE];
    let scale = SIDE as f64 / 2.2;
    for (centre, radius) in balls(curl, spread + 0.05 * shape) {
        let centre = camera_from_hand * ((centre - Vector3::new(0.6, 0.0, 0.0)) * scale);
        let radius = radius * scale * (1.0 + 0.1 * shape);
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let dx = x as f64 + 0.5 - SIDE as f64 / 2.0 - centre.x;
            let dy = y as f64 + 0.5 - SIDE as f64 / 2.0 - centre.y;
            let height = radius * radius - dx * dx - dy * dy;
            let z = centre.z - height.max(0.0).sqrt();
            if height > 0.0 && z < depth[y * SIDE + x] {
                depth[y * SIDE + x] = z;
                let light = (height.sqrt() / radius * 0.8 - dy / radius * 0.3).clamp(0.1, 1.0);
                grey[y * SIDE + x] = (40.0 + 180.0 * light) as u8;
            }
        }
    }
    grey
}

/// A camera direction on the upper half-sphere.
pub(crate) fn view(azimuth_deg: f64, elevation_deg: f64) -> UnitQuaternion<f64> {
    let azimuth = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), azimuth_deg.to_radians());
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), (elevation_deg + 90.0).to_radians()) * azimuth
}

/// The hand image of the ball hand.
pub(crate) fn hand(class: u16, shape: f64, camera_from_hand: &UnitQuaternion<f64>) -> HandImage {
    HandImage::from_segmented(SIDE, SIDE, &picture(class, shape, camera_from_hand), 0)
        .expect("the hand is in view")
}

pub(crate) fn params(classes: u16) -> IndexParams {
    IndexParams {
        classes: (0..classes)
            .map(|class| ClassInfo { name: format!("class-{class}"), cutkosky: class as u8 + 1 })
            .collect(),
        hand_shapes: vec!["balls".into()],
        stages: vec!["close".into(), "grasp".into()],
        seed: 7,
        provenance: vec![("renders".into(), "ball hand".into())],
        ..IndexParams::default()
    }
}

/// An index in memory of `classes` times `azimuths * elevations` views of the ball hand.
pub(crate) fn writer(params: IndexParams, azimuths: u16, elevations: u16) -> IndexWriter {
    fill(IndexWriter::new(params).expect("the parameters are sound"), azimuths, elevations)
}

/// Adds the views of all classes.
pub(crate) fn fill(mut writer: IndexWriter, azimuths: u16, elevations: u16) -> IndexWriter {
    let classes = writer.params().classes.len() as u16;
    let (descriptor, thumbnail_side) = (writer.params().descriptor, writer.params().thumbnail_side as usize);
    for (class, e, a) in
        (0..classes).flat_map(|c| (0..elevations).flat_map(move |e| (0..azimuths).map(move |a| (c, e, a))))
    {
        let azimuth = f64::from(a) * 360.0 / f64::from(azimuths);
        let elevation = f64::from(e) * 90.0 / f64::from(elevations);
        let orientation = view(azimuth, elevation);
        let hand = hand(class, 0.0, &orientation);
        let turn_deg = descriptor.turn_deg(&hand);
        let entry = NewEntry {
            class,
            stage: (a % 2) as u8,
            object: format!("ball-{}", class % 2),
            file: format!("balls/class-{class}/az{azimuth:03.0}_el{elevation:02.0}.png"),
            azimuth_deg: azimuth as f32,
            elevation_deg: elevation as f32,
            orientation,
            source_hash: u64::from(class) << 32 | u64::from(e) << 16 | u64::from(a),
            descriptor: descriptor.describe(&hand).expect("the parameters are in range"),
            thumbnail: (thumbnail_side > 0).then(|| hand.thumbnail(thumbnail_side)),
            ..NewEntry::default()
        };
        writer.push(entry.turned(turn_deg)).expect("the entry fits");
    }
    writer
}

/// An index of a few dozen entries, small enough to break at every byte.
pub(crate) fn small() -> IndexWriter {
    writer(small_params(), 4, 3)
}

/// Writes the same to a file.
pub(crate) fn write_small(path: impl AsRef<Path>) -> Result<Summary, BuildError> {
    write(path, small_params())
}

/// Writes the entries of [`small`] to a file.
pub(crate) fn write(path: impl AsRef<Path>, params: IndexParams) -> Result<Summary, BuildError> {
    finish(fill(IndexWriter::create(path, params)?, 4, 3))
}

/// The parameters of [`small`], but for the hash.
pub(crate) fn small_learned_params() -> IndexParams {
    IndexParams { hash: HashParams::Learned, ..small_params() }
}

/// The parameters of [`small`].
pub(crate) fn small_params() -> IndexParams {
    let hash = HashParams::Random(RandomParams::Fixed { k: 3, t: 3, buckets: 4 });
    IndexParams { hash, thumbnail_side: 4, ..params(3) }
}

/// Writes the index to its file.
pub(crate) fn finish(writer: IndexWriter) -> Result<Summary, BuildError> {
    writer.finish(&|_, _| ControlFlow::Continue(()))
}
