//! What a view shows, texel by texel.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::border::Border;
use super::dressed::{CameraScene, FIRST_OBJECT};
use super::marks::Mark;
use super::randomised::Randomised;
use super::shut::shut;
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

/// What is seen at one texel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Texel {
    /// 0 nothing, 1 the hand with its forearm, 2 the arm that goes on, then the parts of the thing.
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
        self.part >= FIRST_OBJECT
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
        let (projected, texels_a_metre) = project(scene, turn, distance);
        let mut depth = vec![0f32; SIDE * SIDE];
        // Which triangle is seen, and the weights of its second and third corner.
        let mut seen = vec![(u32::MAX, 0f32, 0f32); SIDE * SIDE];
        for (at, (corners, _)) in scene.triangles.iter().enumerate() {
            let corners = corners.map(|v| projected[v as usize]);
            let see = |wb: f32, wc: f32, scale: f32| (at as u32, wb * scale, wc * scale);
            fill(&corners, SIDE, &mut depth, &mut seen, see);
        }
        let mut texels: Vec<Texel> = seen
            .iter()
            .map(|&(at, wb, wc)| texel(scene, turn, at as usize, [1.0 - wb - wc, wb, wc]))
            .collect();
        for ((texel, shut), near) in texels.iter_mut().zip(shut(&depth, SIDE)).zip(&depth) {
            texel.shut = shut;
            // Casting saturates: what is nowhere is far away.
            texel.depth = ((near.recip() - distance) * texels_a_metre / DEPTH) as i16;
        }
        let [hand, thing] = [Texel::is_hand, Texel::is_object].map(|of| Patch::of(&texels, of));
        let (centre, size) = hand.with(&thing);
        let CameraScene { is_sleeved, randomised, .. } = *scene;
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

fn texel(scene: &CameraScene, turn: &Matrix3<f32>, at: usize, weights: [f32; 3]) -> Texel {
    let Some((corners, part)) = scene.triangles.get(at) else { return Texel::default() };
    let mix = |values: [Vector3<f32>; 3]| {
        values.iter().zip(weights).fold(Vector3::zeros(), |sum, (v, weight)| sum + v * weight)
    };
    let is_hand = corners.iter().all(|&v| (v as usize) < scene.hand_vertices);
    let normal = (turn * mix(corners.map(|v| scene.normals[v as usize])))
        .try_normalize(1e-12)
        .unwrap_or_else(|| -Vector3::z());
    let round = |v: f32, limit: f32| (v.clamp(-limit, limit) + if v < 0.0 { -0.5 } else { 0.5 }) as i8;
    Texel {
        part: *part,
        normal: [normal.x, normal.y, normal.z].map(|v| round(v * 127.0, 127.0)),
        place: {
            let place = mix(corners.map(|v| scene.places[v as usize]));
            [place.x, place.y, place.z].map(|v| round(v / STEP, 127.0))
        },
        mark: match is_hand {
            true => {
                let of = |v: u32| {
                    let Mark { palmar, nail, knuckle } = scene.marks[v as usize];
                    Vector3::new(palmar, nail, knuckle)
                };
                let mark = mix(corners.map(of));
                [mark.x, mark.y, mark.z].map(|v| round(v * 127.0, 127.0))
            }
            false => [0; 3],
        },
        shut: 0,
        depth: 0,
    }
}

/// Every vertex in the frame that shows the hand, without its arm, in the middle; and how many
/// texels wide a metre is there.
fn project(scene: &CameraScene, turn: &Matrix3<f32>, distance: f32) -> (Vec<Projected>, f32) {
    let hand = |at: usize| at < scene.hand_vertices && scene.places[at].x > WRIST;
    let (mut low, mut high) = (Vector3::repeat(f32::MAX), Vector3::repeat(f32::MIN));
    for (_, v) in scene.vertices.iter().enumerate().filter(|(at, _)| hand(*at)) {
        (low, high) = (low.inf(v), high.sup(v));
    }
    let centre = (low + high) * 0.5;
    let mut out: Vec<Projected> = scene
        .vertices
        .iter()
        .map(|v| {
            let c = turn * (v - centre);
            // What would lie behind the camera is far out of the picture all the same.
            let near = 1.0 / (c.z + distance).max(0.1 * distance);
            Projected { x: c.x * near, y: c.y * near, near, grey: 0.0 }
        })
        .collect();
    let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
    for (_, p) in out.iter().enumerate().filter(|(at, _)| hand(*at)) {
        low = [low[0].min(p.x), low[1].min(p.y)];
        high = [high[0].max(p.x), high[1].max(p.y)];
    }
    let zoom = SHARE * SIDE as f32 / (high[0] - low[0]).max(high[1] - low[1]).max(1e-9);
    let shift = [0, 1].map(|i| 0.5 * (SIDE as f32 - zoom * (low[i] + high[i])));
    for p in &mut out {
        (p.x, p.y) = (p.x * zoom + shift[0], p.y * zoom + shift[1]);
    }
    (out, zoom / distance)
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
    /// Sides of pictures that show a thing large, in roots of the area that is seen of it; about
    /// the least side, in roots of the hand's area; and the least area in texels.
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
