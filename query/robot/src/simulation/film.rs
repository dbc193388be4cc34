//! Pictures of a trial, drawn with a depth buffer and the shadow on the table.

use image::{Rgb, RgbImage};
use rapier3d::math::{Pose, Vector};

use super::trial::{Offset, Outcome, Plan};
use super::world::World;
use crate::{ApproachSide, Object, Shape};

/// How many times finer a frame is drawn.
const FINER: u32 = 2;
/// What a frame shows, in metres, and where its middle is over the table.
const VIEW: f32 = 0.46;
const MIDDLE: f32 = 0.15;
/// Frames of a film.
const FRAMES: usize = 5;
/// From where it is seen, and from where the light comes.
const EYE: Vector = Vector::new(-0.62, -0.66, 0.42);
const LIGHT: Vector = Vector::new(-0.60, -0.25, 0.76);
/// What of the light reaches a face that looks away from it, and what of it a shadow.
const AMBIENT: f32 = 0.45;
const SHADE: f32 = 0.70;

const TABLE: [f32; 3] = [214.0, 205.0, 190.0];
const HAND: [f32; 3] = [120.0, 130.0, 145.0];
const LINK: [f32; 3] = [165.0, 174.0, 186.0];
const THING: [f32; 3] = [230.0, 120.0, 50.0];

/// Five moments of a trial: settled, about to close, closed, half way up, held.
#[derive(Clone, Debug)]
pub struct Film {
    /// What was seen, each [`Self::SIDE`] wide and high; fewer than captions where the trial ended
    /// before.
    pub frames: Vec<RgbImage>,
    /// What each frame shows, and what became of it.
    pub captions: [String; FRAMES],
}

impl Film {
    /// A frame's side in pixels.
    pub const SIDE: u32 = 300;
    /// The colour behind everything.
    pub const BACKGROUND: [u8; 3] = [244, 245, 247];
}

impl Plan {
    /// [`Self::run`], and what was seen of it.
    pub fn film(&self, offset: Offset) -> (Outcome, Film) {
        let mut frames = Vec::new();
        let moments = self.moments();
        let (outcome, _) = self.run_watched(offset, |world, now| {
            if moments.get(frames.len()).is_some_and(|moment| now >= *moment) {
                frames.push(frame(world, self.object()));
            }
        });
        let captions = captions(self, &outcome);
        (outcome, Film { frames, captions })
    }
}

/// What each frame shows, and what became of it.
fn captions(plan: &Plan, outcome: &Outcome) -> [String; FRAMES] {
    let (from, distance) = plan.way();
    let side = match from {
        Some(ApproachSide::Top) => "above",
        Some(ApproachSide::Side) => "beside",
        None => "below",
    };
    // Without a sign: what moves by less than half a millimetre does not move.
    let millimetres = |value: f64| value.round().abs();
    let end = match (outcome.success, outcome.lifted) {
        (true, _) => format!("lifted, slip {} mm", millimetres(outcome.slip_mm)),
        (false, true) => format!("slipping, {} mm", millimetres(outcome.slip_mm)),
        (false, false) => "not lifted".into(),
    };
    [
        format!("open, {:.0} mm {side}", 1e3 * distance),
        "about to close".into(),
        format!("closed, pushed {} mm", millimetres(outcome.pushed_mm)),
        "lifting".into(),
        end,
    ]
}

fn frame(world: &World, object: &Object) -> RgbImage {
    let mut canvas = Canvas::new(Film::SIDE * FINER);
    let mut solids = vec![(faces(object), world.object(), THING)];
    for (at, (solid, pose)) in world.hand_solids().into_iter().enumerate() {
        let pose = pose * Pose::from_translation(solid.middle);
        solids.push((cuboid(solid.half), pose, if at == 0 { HAND } else { LINK }));
    }
    if let Some(table) = object.table {
        let slab = Vector::new(0.22, 0.22, 0.004);
        let at = Pose::from_translation(Vector::new(0.0, 0.0, table as f32 - slab.z));
        canvas.draw(&cuboid(slab), &at, TABLE);
        for (faces, at, _) in &solids {
            canvas.shade(faces, at, table as f32);
        }
    }
    for (faces, at, colour) in &solids {
        canvas.draw(faces, at, *colour);
    }
    image::imageops::thumbnail(&canvas.picture, Film::SIDE, Film::SIDE)
}

/// Convex faces, each a list of corners.
type Faces = Vec<Vec<Vector>>;

fn faces(object: &Object) -> Faces {
    match object.shape {
        Shape::Box { size } => {
            let [x, y, z] = size.map(|length| 0.5 * length as f32);
            cuboid(Vector::new(x, y, z))
        }
        Shape::Cylinder { radius, height } => {
            let ring = [(0.5 * height as f32, radius as f32), (-0.5 * height as f32, radius as f32)];
            turned(&ring, 40)
        }
        Shape::Sphere { radius } => {
            let radius = radius as f32;
            let rings: Vec<(f32, f32)> = (0..=14_u8)
                .map(|ring| {
                    let (sin, cos) = (std::f32::consts::PI * f32::from(ring) / 14.0).sin_cos();
                    (radius * cos, radius * sin)
                })
                .collect();
            turned(&rings, 28)
        }
    }
}

/// A body of rotation about z: rings of height and radius from top to bottom, with lids.
fn turned(rings: &[(f32, f32)], sides: u32) -> Faces {
    let ring = |&(z, radius): &(f32, f32)| -> Vec<Vector> {
        (0..sides)
            .map(|side| {
                let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
                Vector::new(radius * cos, radius * sin, z)
            })
            .collect()
    };
    let rings: Vec<Vec<Vector>> = rings.iter().map(ring).collect();
    let mut faces: Faces = [rings.first(), rings.last()].into_iter().flatten().cloned().collect();
    for (upper, lower) in rings.iter().zip(rings.iter().skip(1)) {
        let next = |ring: &[Vector]| -> Vec<Vector> {
            ring.iter().cycle().skip(1).take(ring.len()).copied().collect()
        };
        for (((a, b), c), d) in upper.iter().zip(next(upper)).zip(next(lower)).zip(lower) {
            faces.push(vec![*a, b, c, *d]);
        }
    }
    faces
}

fn cuboid(half: Vector) -> Faces {
    let corner = |x: f32, y: f32, z: f32| Vector::new(x, y, z) * half;
    let mut faces = Vec::new();
    for sign in [-1.0, 1.0] {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        faces.push(square.map(|(a, b)| corner(sign, a, b)).to_vec());
        faces.push(square.map(|(a, b)| corner(a, sign, b)).to_vec());
        faces.push(square.map(|(a, b)| corner(a, b, sign)).to_vec());
    }
    faces
}

/// A picture with a depth for each pixel.
struct Canvas {
    picture: RgbImage,
    depth: Vec<f32>,
    side: u32,
}

impl Canvas {
    fn new(side: u32) -> Self {
        let depth = vec![f32::NEG_INFINITY; (side * side) as usize];
        Self { picture: RgbImage::from_pixel(side, side, Rgb(Film::BACKGROUND)), depth, side }
    }

    fn draw(&mut self, faces: &Faces, at: &Pose, colour: [f32; 3]) {
        for face in faces {
            let corners: Vec<Vector> = face.iter().map(|corner| at.transform_point(*corner)).collect();
            let middle = corners.iter().copied().sum::<Vector>() / corners.len() as f32;
            let [a, b, c, ..] = corners[..] else { continue };
            let mut normal = (b - a).cross(c - a).normalize_or_zero();
            // Whichever way its corners run, a face of a convex body looks away from the body's
            // middle.
            if normal.dot(middle - at.translation) < 0.0 {
                normal = -normal;
            }
            let colour = lit(colour, normal);
            self.face(&corners, |pixel, nearest, depth| {
                if depth > *nearest {
                    *nearest = depth;
                    *pixel = colour;
                }
            });
        }
    }

    /// Darkens the table where a solid keeps the light from it. Of what is drawn already, only the
    /// table's surface has its colour.
    fn shade(&mut self, faces: &Faces, at: &Pose, table: f32) {
        let surface = lit(TABLE, Vector::Z);
        let shadow = Rgb(surface.0.map(|value| (f32::from(value) * SHADE) as u8));
        let cast = |corner: &Vector| {
            let corner = at.transform_point(*corner);
            corner - LIGHT * ((corner.z - table).max(0.0) / LIGHT.z)
        };
        for face in faces {
            let corners: Vec<Vector> = face.iter().map(cast).collect();
            self.face(&corners, |pixel, _, _| {
                if *pixel == surface {
                    *pixel = shadow;
                }
            });
        }
    }

    /// Visits every pixel of a convex face, with the depth there so far and the face's.
    fn face(&mut self, corners: &[Vector], mut visit: impl FnMut(&mut Rgb<u8>, &mut f32, f32)) {
        let [a, ..] = corners[..] else { return };
        for (second, third) in corners.iter().skip(1).zip(corners.iter().skip(2)) {
            self.triangle([a, *second, *third].map(|corner| self.project(corner)), &mut visit);
        }
    }

    /// Right, down and toward the eye, in pixels.
    fn project(&self, point: Vector) -> [f32; 3] {
        let toward = EYE.normalize();
        let right = Vector::Z.cross(toward).normalize();
        let up = toward.cross(right);
        let scale = self.side as f32 / VIEW;
        let point = point - Vector::new(0.0, 0.0, MIDDLE);
        let half = 0.5 * self.side as f32;
        [half + scale * point.dot(right), half - scale * point.dot(up), scale * point.dot(toward)]
    }

    fn triangle(&mut self, [a, b, c]: [[f32; 3]; 3], visit: &mut impl FnMut(&mut Rgb<u8>, &mut f32, f32)) {
        let edge = |p: [f32; 3], q: [f32; 3], x: f32, y: f32| {
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
        };
        let area = edge(a, b, c[0], c[1]);
        if area == 0.0 {
            return;
        }
        let range = |axis: usize| {
            let values = [a[axis], b[axis], c[axis]];
            let least = values.into_iter().fold(f32::INFINITY, f32::min).floor().max(0.0);
            let most = values.into_iter().fold(0.0, f32::max).ceil().min(self.side as f32);
            least as u32..most as u32
        };
        for y in range(1) {
            for x in range(0) {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let weights = [edge(b, c, px, py), edge(c, a, px, py), edge(a, b, px, py)].map(|w| w / area);
                if weights.iter().any(|weight| *weight < 0.0) {
                    continue;
                }
                let depth = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                let Some(nearest) = self.depth.get_mut((y * self.side + x) as usize) else { continue };
                visit(self.picture.get_pixel_mut(x, y), nearest, depth);
            }
        }
    }
}

/// The colour of a face that looks along `normal`.
fn lit(colour: [f32; 3], normal: Vector) -> Rgb<u8> {
    let light = AMBIENT + (1.0 - AMBIENT) * normal.dot(LIGHT.normalize()).max(0.0);
    Rgb(colour.map(|value| (value * light) as u8))
}
