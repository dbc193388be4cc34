//! What a view shows, texel by texel.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::border::Border;
use super::company::{FIRST_MATERIAL, SECOND_ARM};
use super::marks::Mark;
use super::randomised::Randomised;
use super::scene::{CameraScene, FIRST_OBJECT, FIRST_OF_COMPANY};
use super::shut::shut;
use super::surface_mesh::SurfaceMesh;
use crate::random::{between, normal, unit};
use crate::raster::{Projected, fill};
use crate::view::View;

/// Texels a side.
pub(super) const SIDE: usize = 160;
/// The share of them that the hand takes without its arm.
const SHARE: f32 = 0.36;
/// Where the hand ends and the forearm begins, in metres along x.
const WRIST: f32 = -0.02;
/// Steps of a depth in widths of a texel.
const DEPTH: f32 = 1.0 / 16.0;
/// Steps of a place in metres.
const STEP: f32 = 0.0015;

/// The least share of hand and thing that is seen; what else there is and would hide more of them
/// is left out.
const LEAST_SEEN: f32 = 0.75;

/// What is seen at one texel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Texel {
    /// 0 nothing, 1 the hand with its forearm, 2 the arm that goes on, then the parts of the thing,
    /// and of what is not the hand's own.
    pub(super) part: u8,
    /// The normal in the camera's frame, times 127.
    normal: [i8; 3],
    /// The place in the hand's frame while the wrist was straight, in steps.
    place: [i8; 3],
    /// What the skin has: see [`Texel::mark`].
    mark: [i8; 3],
    /// How much of what lies around is nearer to the camera, 0 to 255.
    shut: u8,
    /// How far behind the hand's middle it lies, in [`DEPTH`] of a texel's width.
    depth: i16,
}

impl Texel {
    pub(super) fn normal(&self) -> [f32; 3] {
        self.normal.map(|v| f32::from(v) / 127.0)
    }

    /// In metres, to 1.5 mm and to 19 cm from the wrist.
    pub(super) fn place(&self) -> [f32; 3] {
        self.place.map(|v| f32::from(v) * STEP)
    }

    /// What the skin has here.
    pub(super) fn mark(&self) -> Mark {
        let [palmar, nail, knuckle] = self.mark.map(|v| f32::from(v) / 127.0);
        Mark { palmar, nail, knuckle }
    }

    /// The share of light from all around that does not come in, 0 to 1.
    pub(super) fn shut(&self) -> f32 {
        f32::from(self.shut) / 255.0
    }

    /// How far behind the hand's middle it lies, in widths of a texel.
    pub(super) fn depth(&self) -> f32 {
        f32::from(self.depth) * DEPTH
    }

    pub(super) fn is_hand(&self) -> bool {
        self.part == 1 && self.place()[0] > WRIST
    }

    /// The forearm, and the arm that goes on behind it.
    pub(super) fn is_arm(&self) -> bool {
        matches!(self.part, 1 | 2) && !self.is_hand()
    }

    /// The arm that goes on behind the forearm.
    pub(super) fn is_far_arm(&self) -> bool {
        self.part == 2
    }

    pub(super) fn is_object(&self) -> bool {
        (FIRST_OBJECT..FIRST_OF_COMPANY).contains(&self.part)
    }

    /// The arm that goes on behind a second hand's forearm.
    pub(super) fn is_second_far_arm(&self) -> bool {
        self.part == SECOND_ARM
    }

    /// The number of the material that things about the hand are made of.
    pub(super) fn material_of_company(&self) -> Option<usize> {
        self.part.checked_sub(FIRST_MATERIAL).map(usize::from)
    }
}

/// One view of a [`CameraScene`].
#[derive(Debug, Clone)]
pub struct Layers {
    texels: Vec<Texel>,
    /// The middle of what is seen of hand and thing, in texels.
    centre: [f32; 2],
    /// The root of the area that is seen of both: see [`Layers::size`].
    size: f32,
    /// What is seen of the hand, and of the thing.
    hand: Patch,
    thing: Patch,
    pub(super) is_sleeved: bool,
    pub(super) randomised: Randomised,
    /// The rotation from the hand's frame into the camera's.
    pub camera_from_hand: UnitQuaternion<f64>,
}

impl CameraScene {
    /// What a view shows, from `distance` hand lengths away.
    pub fn layers(&self, view: &View, distance: f64) -> Layers {
        Layers::draw(self, view.camera_from_world() * self.world_from_hand, distance * self.hand_length)
    }
}

impl Layers {
    /// `distance` is in metres.
    fn draw(scene: &CameraScene, camera_from_hand: UnitQuaternion<f64>, distance: f64) -> Self {
        let turn: &Matrix3<f32> = &camera_from_hand.to_rotation_matrix().matrix().cast();
        let distance = distance as f32;
        let camera = Camera::of(scene, turn, distance);
        let mut canvas = Canvas::new();
        canvas.fill(&scene.own, &camera, 0);
        if !scene.company.triangles.is_empty() {
            let alone = canvas.clone();
            canvas.fill(&scene.company, &camera, scene.own.triangles.len());
            if canvas.hides_too_much(&alone, scene) {
                canvas = alone;
            }
        }
        let Canvas { depth, seen } = canvas;
        let mut texels: Vec<Texel> = seen
            .iter()
            .map(|&(at, wb, wc)| texel(scene, turn, at as usize, [1.0 - wb - wc, wb, wc]))
            .collect();
        for ((texel, shut), near) in texels.iter_mut().zip(shut(&depth, SIDE)).zip(&depth) {
            texel.shut = shut;
            // Casting saturates: what is nowhere is far away.
            texel.depth = ((near.recip() - distance) * camera.texels_a_metre / DEPTH) as i16;
        }
        let [hand, thing] = [Texel::is_hand, Texel::is_object].map(|of| Patch::of(&texels, of));
        let (centre, size) = hand.with(&thing);
        let (is_sleeved, randomised) = (scene.is_sleeved(), scene.randomised);
        Self { texels, centre, size, hand, thing, is_sleeved, randomised, camera_from_hand }
    }

    /// A view of nothing: what lies behind is all that there is.
    pub fn of_nothing(randomised: Randomised) -> Self {
        Self {
            texels: vec![Texel::default(); SIDE * SIDE],
            centre: [SIDE as f32 / 2.0; 2],
            size: SHARE * SIDE as f32,
            hand: Patch::default(),
            thing: Patch::default(),
            is_sleeved: false,
            randomised,
            camera_from_hand: UnitQuaternion::identity(),
        }
    }

    /// The texel at a place; beyond the border what lies at it goes on.
    pub(super) fn at(&self, x: f32, y: f32) -> &Texel {
        let place = |v: f32| (v.max(0.0) as usize).min(SIDE - 1);
        &self.texels[place(y) * SIDE + place(x)]
    }

    /// How large hand and thing are in texels: the root of the area that is seen of them, of the
    /// thing's at most two and a half times the hand's.
    pub fn size(&self) -> f32 {
        self.size
    }

    /// The area that is seen of the hand, in texels; 0 where something hides it.
    pub fn hand_area(&self) -> f32 {
        self.hand.area
    }
}

/// How much of a thing's area counts for the size of what is looked at, in areas of its hand.
/// Whoever frames a camera's picture for a network that learned from these frames it alike.
const MOST_OF_THING: f32 = 2.5;
/// How much of a thing's area counts for the middle of it.
const THING_IN_MIDDLE: f32 = 0.5;

/// What is seen of a part.
#[derive(Debug, Clone, Copy, Default)]
struct Patch {
    /// The sum of its texels' places.
    sum: [f32; 2],
    area: f32,
}

impl Patch {
    fn of(texels: &[Texel], is_part: fn(&Texel) -> bool) -> Self {
        let (mut sum, mut area) = ([0.0; 2], 0.0);
        for (at, _) in texels.iter().enumerate().filter(|(_, texel)| is_part(texel)) {
            sum = [sum[0] + (at % SIDE) as f32 + 0.5, sum[1] + (at / SIDE) as f32 + 0.5];
            area += 1.0;
        }
        Self { sum, area }
    }

    /// Its middle.
    fn middle(&self) -> [f32; 2] {
        match self.area {
            0.0 => [SIDE as f32 / 2.0; 2],
            area => self.sum.map(|sum| sum / area),
        }
    }

    /// The middle of a hand with the thing that it holds, and the root of their area.
    fn with(&self, thing: &Self) -> ([f32; 2], f32) {
        if self.area == 0.0 {
            return (self.middle(), 0.0);
        }
        let seen = thing.area.min(MOST_OF_THING * self.area);
        let share = THING_IN_MIDDLE * seen / thing.area.max(1.0);
        let area = self.area + share * thing.area;
        let centre = [0, 1].map(|i| (self.sum[i] + share * thing.sum[i]) / area);
        (centre, (self.area + seen).sqrt())
    }
}

/// What is nearest at each texel of a view that is being drawn.
#[derive(Clone)]
struct Canvas {
    /// The inverse of its distance in metres; 0 where there is nothing.
    depth: Vec<f32>,
    /// Which triangle is seen, and the weights of its second and third corner.
    seen: Vec<(u32, f32, f32)>,
}

impl Canvas {
    fn new() -> Self {
        Self { depth: vec![0.0; SIDE * SIDE], seen: vec![(u32::MAX, 0.0, 0.0); SIDE * SIDE] }
    }

    /// Draws triangles, the first of them as number `first`.
    fn fill(&mut self, mesh: &SurfaceMesh, camera: &Camera<'_>, first: usize) {
        let projected: Vec<Projected> = mesh.vertices.iter().map(|v| camera.project(v)).collect();
        for (at, (corners, _)) in mesh.triangles.iter().enumerate() {
            let corners = corners.map(|v| projected[v as usize]);
            let see = |wb: f32, wc: f32, scale: f32| ((first + at) as u32, wb * scale, wc * scale);
            fill(&corners, SIDE, &mut self.depth, &mut self.seen, see);
        }
    }

    /// Whether much of hand and thing can no longer be seen that could `before`.
    fn hides_too_much(&self, before: &Self, scene: &CameraScene) -> bool {
        let is_own = |(at, ..): &&(u32, f32, f32)| {
            let part = scene.own.triangles.get(*at as usize).map(|(_, part)| *part);
            part.is_some_and(|part| part == 1 || part >= FIRST_OBJECT)
        };
        let count = |canvas: &Self| canvas.seen.iter().filter(is_own).count() as f32;
        count(self) < LEAST_SEEN * count(before)
    }
}

fn texel(scene: &CameraScene, turn: &Matrix3<f32>, at: usize, weights: [f32; 3]) -> Texel {
    let own = scene.own.triangles.get(at).map(|triangle| (&scene.own, triangle));
    let of_company = || {
        let at = at.checked_sub(scene.own.triangles.len())?;
        scene.company.triangles.get(at).map(|triangle| (&scene.company, triangle))
    };
    let Some((mesh, (corners, part))) = own.or_else(of_company) else { return Texel::default() };
    let mix = |values: [Vector3<f32>; 3]| {
        values.iter().zip(weights).fold(Vector3::zeros(), |sum, (v, weight)| sum + v * weight)
    };
    let normal = (turn * mix(corners.map(|v| mesh.normals[v as usize])))
        .try_normalize(1e-12)
        .unwrap_or_else(|| -Vector3::z());
    let round = |v: f32, limit: f32| (v.clamp(-limit, limit) + if v < 0.0 { -0.5 } else { 0.5 }) as i8;
    let place = mix(corners.map(|v| mesh.places[v as usize]));
    let mark = mix(corners.map(|v| {
        let Mark { palmar, nail, knuckle } = mesh.marks[v as usize];
        Vector3::new(palmar, nail, knuckle)
    }));
    Texel {
        part: *part,
        normal: [normal.x, normal.y, normal.z].map(|v| round(v * 127.0, 127.0)),
        place: [place.x, place.y, place.z].map(|v| round(v / STEP, 127.0)),
        mark: [mark.x, mark.y, mark.z].map(|v| round(v * 127.0, 127.0)),
        shut: 0,
        depth: 0,
    }
}

/// The frame that shows the hand, without its arm, in the middle.
struct Camera<'a> {
    turn: &'a Matrix3<f32>,
    centre: Vector3<f32>,
    distance: f32,
    zoom: f32,
    shift: [f32; 2],
    /// How many texels wide a metre is at the hand.
    texels_a_metre: f32,
}

impl<'a> Camera<'a> {
    fn of(scene: &CameraScene, turn: &'a Matrix3<f32>, distance: f32) -> Self {
        let SurfaceMesh { vertices, places, .. } = &scene.own;
        let hand = vertices.iter().zip(places).take(scene.hand_vertices);
        let hand: Vec<_> = hand.filter(|(_, place)| place.x > WRIST).map(|(v, _)| v).collect();
        let (mut low, mut high) = (Vector3::repeat(f32::MAX), Vector3::repeat(f32::MIN));
        hand.iter().for_each(|v| (low, high) = (low.inf(v), high.sup(v)));
        let centre = (low + high) * 0.5;
        let mut camera =
            Self { turn, centre, distance, zoom: 1.0, shift: [0.0; 2], texels_a_metre: 1.0 / distance };
        let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
        for p in hand.iter().map(|v| camera.project(v)) {
            low = [low[0].min(p.x), low[1].min(p.y)];
            high = [high[0].max(p.x), high[1].max(p.y)];
        }
        camera.zoom = SHARE * SIDE as f32 / (high[0] - low[0]).max(high[1] - low[1]).max(1e-9);
        camera.shift = [0, 1].map(|i| 0.5 * (SIDE as f32 - camera.zoom * (low[i] + high[i])));
        camera.texels_a_metre *= camera.zoom;
        camera
    }

    fn project(&self, v: &Vector3<f32>) -> Projected {
        let c = self.turn * (v - self.centre);
        // What would lie behind the camera is far out of the picture all the same.
        let near = 1.0 / (c.z + self.distance).max(0.1 * self.distance);
        let [x, y] = [(c.x, 0), (c.y, 1)].map(|(at, i)| at * near * self.zoom + self.shift[i]);
        Projected { x, y, near, grey: 0.0 }
    }
}

/// Which square of a view a picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// Its middle in texels.
    pub(super) centre: [f32; 2],
    /// Its side in texels.
    pub(super) side: f32,
    /// By how many radians the picture's content is turned clockwise.
    pub turn: f64,
    /// Where the picture ends that it is cut from.
    pub(super) border: Border,
}

impl Framing {
    /// Sides of pictures that show a hand and what it holds, and of whole pictures, in which they
    /// are to be found, in sizes of both ([`Layers::size`]).
    const NEAR: [f64; 2] = [1.5, 2.9];
    const FOUND: [f64; 2] = [1.6, 2.7];
    const FAR: [f64; 2] = [1.5, 8.0];
    /// Sides of pictures that show a thing large, in roots of the area that is seen of it; about the
    /// least side, in roots of the hand's area; and the least area in texels.
    const OF_THING: [f64; 2] = [1.5, 2.6];
    const LEAST_OF_HAND: f64 = 0.9;
    const LEAST_OF_THING: f32 = 30.0;
    /// By how many shares of its side such a picture is off the thing's middle (standard
    /// deviation).
    const THING_OFF: f64 = 0.1;
    /// By how many shares of its side a picture is off the hand's middle (standard deviation).
    const NEAR_OFF: f64 = 0.06;
    const FAR_OFF: f64 = 0.25;
    /// How far an arm is from coming straight from below, in radians (standard deviation), and how
    /// often it comes from anywhere.
    const NEAR_TURN: f64 = 0.35;
    const ANY_TURN: f64 = 0.1;
    const FOUND_TURN: f64 = 0.3;
    const ANY_FOUND_TURN: f64 = 0.04;
    /// The share of whole pictures in which the arm comes from below, within so many radians, as
    /// the holder's own does.
    const FROM_BELOW: f64 = 0.5;
    const BELOW: f64 = 1.9;

    /// A square around the hand, the arm about from below: what a hand that was seen is looked at
    /// in to make it out.
    pub fn near(layers: &Layers, rng: &mut ChaCha8Rng) -> Self {
        Self::around(layers, Self::NEAR, Self::NEAR_TURN, Self::ANY_TURN, rng)
    }

    /// The same, nearer to what is meant: what a hand that was made out is looked at in to name it.
    pub fn found(layers: &Layers, rng: &mut ChaCha8Rng) -> Self {
        Self::around(layers, Self::FOUND, Self::FOUND_TURN, Self::ANY_FOUND_TURN, rng)
    }

    /// The same around the hand alone, where all else is cut away.
    pub fn cut_out(layers: &Layers, rng: &mut ChaCha8Rng) -> Self {
        let both = Self::found(layers, rng);
        let (smaller, middle) = (layers.hand.area.sqrt() / layers.size, layers.hand.middle());
        let off = |i: usize| smaller * (both.centre[i] - layers.centre[i]);
        let centre = [0, 1].map(|i| middle[i] + off(i));
        Self { centre, side: smaller * both.side, ..both }
    }

    /// A square around what is seen of the thing, in which it is larger than in one around the
    /// hand; [`Self::found`] where hardly anything is seen of it.
    pub fn thing(layers: &Layers, rng: &mut ChaCha8Rng) -> Self {
        let found = Self::found(layers, rng);
        let thing = &layers.thing;
        if thing.area < Self::LEAST_OF_THING {
            return found;
        }
        let [low, high] = Self::OF_THING;
        let side = low * libm::pow(high / low, unit(rng)) * f64::from(thing.area).sqrt();
        let least = Self::LEAST_OF_HAND * f64::from(layers.hand.area).sqrt();
        let side = side.max(least * libm::exp(0.2 * normal(rng)));
        let centre = Self::beside(thing.middle(), side, Self::THING_OFF, rng);
        Self { centre, side: side as f32, ..found }
    }

    fn around(layers: &Layers, sizes: [f64; 2], turn: f64, any: f64, rng: &mut ChaCha8Rng) -> Self {
        let turn = match unit(rng) < any {
            true => std::f64::consts::TAU * unit(rng),
            false => turn * normal(rng),
        };
        let border = if layers.randomised.borders { Border::near(rng) } else { Border::NONE };
        Self::of(layers, sizes, Self::NEAR_OFF, turn, border, rng)
    }

    /// A larger square with the hand anywhere in it, the arm from anywhere, but often from below.
    pub fn far(layers: &Layers, rng: &mut ChaCha8Rng) -> Self {
        let turn = match unit(rng) < Self::FROM_BELOW {
            true => between(rng, [-Self::BELOW, Self::BELOW]),
            false => std::f64::consts::TAU * unit(rng),
        };
        Self::of(layers, Self::FAR, Self::FAR_OFF, turn, Border::whole(rng), rng)
    }

    /// A square with a side of so many `sizes` of the hand; without `turn` the arm points down.
    fn of(
        layers: &Layers,
        [low, high]: [f64; 2],
        off: f64,
        turn: f64,
        border: Border,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let side = low * libm::pow(high / low, unit(rng)) * f64::from(layers.size());
        let centre = Self::beside(layers.centre, side, off, rng);
        let arm = layers.camera_from_hand * -Vector3::x();
        let turn = std::f64::consts::FRAC_PI_2 - libm::atan2(arm.y, arm.x) + turn;
        Self { centre, side: side as f32, turn, border }
    }

    /// About `middle`: off by shares of a square's side, `off` by standard deviation.
    fn beside(middle: [f32; 2], side: f64, off: f64, rng: &mut ChaCha8Rng) -> [f32; 2] {
        let off = [0; 2].map(|_| (off * normal(rng)).clamp(-0.36, 0.36));
        [0, 1].map(|i| middle[i] + (side * off[i]) as f32)
    }

    /// The map from places of the picture, 0 to 1 right and down, to texels of the view.
    pub(super) fn map(&self) -> Map {
        let (sin, cos) = libm::sincosf(self.turn as f32);
        Map { centre: self.centre, along: [cos * self.side, sin * self.side] }
    }
}

/// See [`Framing::map`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Map {
    centre: [f32; 2],
    /// Cosine and sine of the turn, times the side.
    along: [f32; 2],
}

impl Map {
    pub(super) fn place(&self, u: f32, v: f32) -> [f32; 2] {
        let ([cos, sin], x, y) = (self.along, u - 0.5, v - 0.5);
        [self.centre[0] + cos * x + sin * y, self.centre[1] - sin * x + cos * y]
    }
}
